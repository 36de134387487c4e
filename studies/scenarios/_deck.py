"""Decks of MPM3D: the text of an input file, read macro by macro into a ``Deck`` in SI.

A deck is lines of words, parted by blanks, tabs or commas; ``!`` begins a comment. A word's first four letters name a
macro, in either case, and the numbers after it are its parameters. Two dialects have most macros in common:

Ma (2005), appendix A. The copy of the thesis at hand is a scan whose text layer has lost characters. Read there: the
macros with their comments, all numbers but the ones that follow, and that ``!`` comments. Reconstructed, as columns of
the same table say: "mpm3c l *** test t my Co de" is a title, "jaum or n" is ``jaum on``, "10 0.0d3" is 100.0d3, "3
70.0d3" and "9 0 39 02 0." are 70.0d3, 90, 392 and 0.5, and "0.2500D00+00" is 0.2500D+00. The heading of ``seos`` is
"comp", but the two numbers there are those of the materials as well; MPM3D-F90 calls it a material, and so it is read.
A particle has no mass: it is density dcell^3 / ppc. ``john`` ends with C; the reference rate is 1/s, and temperature is
left out (section 2.1.2). Of 260 particles two are printed, the first and, as number "12", one of component 2 at (0.75,
0.25, 5.25). They are the quarter of a bar of section 2.3.1, which has 260 particles, the density, modulus and Poisson's
ratio of material 1 and cells of 1 mm: 20 layers of 13, whose upper half is component 2, so that layer 11 begins at 5.25
and its second particle is number 132, one lost digit from what is printed.

MPM3D-F90 (github.com/xzhang66/MPM3D-F90, src/DataIn.f90 and FFI.f90 as of 4a6275f): the macros of its reader with the
order of their numbers. ``seos n 1`` has eight numbers there and three in the thesis; ``null`` has had one number (wave
speed) and now two. A block's third number is a density in the present reader and the mass of a particle in
some of its decks: which of the two follows from the density of the material. What no run here needs (output files,
reports, plotted regions) is read, checked and listed as unused; what changes the mechanics and has no counterpart here
(staggered grids, total Lagrangian particles, dynamic relaxation, forces) is refused with its line.

Units are those that a comment "Unit: ..." names, millimetre, gram and millisecond by default, as in the thesis. A
number is shifted by its power of ten as text and rounded once, so that a deck can hold every double exactly.

Sizes are compared with limits before anything of that size is made: a deck is at most 1 MB and 20 million particles.
"""

import re
from collections.abc import Callable
from functools import lru_cache
from typing import Any, NoReturn

from studies.scenarios._deck_checks import count_of, finished, least_count
from studies.scenarios._deck_macros import EOS_COUNTS, KINDS, OPTIONS, REFUSED, TITLES, Quantity
from studies.scenarios._deck_records import (
    MOST_NODES,
    MOST_PARTICLES,
    Deck,
    DeckBody,
    DeckGravity,
    DeckMaterial,
    DeckState,
    DeckVelocity,
    Lattice,
    refuse_line,
)
from studies.scenarios._deck_words import INTEGER, SEPARATORS, Word, Words
from studies.values.errors import Finding, InvalidInput
from studies.values.nearest import nearest_cure

MOST_BYTES = 1_000_000
LENGTHS: tuple[Quantity, ...] = ("length",) * 6
DENSITY_OR_MASS = 0.01  # relative: what a block's third number must agree with


def read_file_text(content: bytes) -> str:
    """The text of a deck's file; raises InvalidInput for what is no UTF-8, with the line, and for more than 1 MB."""
    if len(content) > MOST_BYTES:
        _refuse_size(len(content))
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        refuse_line(line, f"byte {content[error.start]:#04x}", "UTF-8 text", "save the deck as UTF-8")


@lru_cache(maxsize=4)
def read_deck(text: str, units: str = "deck") -> Deck:
    """The deck of a text, in the units that it names or in others; raises InvalidInput with line and cure."""
    if len(text) > MOST_BYTES or len(text.encode()) > MOST_BYTES:
        _refuse_size(len(text.encode()))
    return _Reader(text, units).deck()


def _refuse_size(size: int) -> NoReturn:
    cure = "give blocks and spheres in the place of points, or fewer particles"
    raise InvalidInput([Finding("deck", f"{size} bytes", f"at most {MOST_BYTES} bytes", cure)])


class _Reader(Words):
    """One deck being read."""

    def __init__(self, text: str, units: str):
        super().__init__(text)
        self.units = self._units(units)
        self.state = DeckState()

    def deck(self) -> Deck:
        """Read all macros up to ``endi``."""
        handlers = self._handlers()
        while True:
            word = self.next("endi, the end of the deck")
            if word.key == "endi":
                return finished(self.state, self.units, word.line)
            if word.key in REFUSED:
                refuse_line(word.line, word.text, *REFUSED[word.key])
            if word.key not in handlers:
                refuse_line(word.line, f"the macro {word.text!r}", "a macro of MPM3D", nearest_cure(word.key, handlers))
            handlers[word.key](word)

    def _units(self, asked: str) -> str:
        if asked != "deck":
            return asked
        for number, line in enumerate(self.lines, 1):
            found = re.search(r"!\s*units?\s*[:=]\s*(.*)", line, re.IGNORECASE)
            if found:
                names = set(SEPARATORS.split(found[1].strip().lower()))
                if {"mm", "g", "ms"} <= names:
                    return "mm-g-ms"
                if {"m", "kg", "s"} <= names:
                    return "SI"
                cure = "set units to mm-g-ms or SI"
                refuse_line(number, found[1].strip()[:60], "mm g N ms MPa, or m kg N s Pa", cure)
        return "mm-g-ms"

    def _handlers(self) -> dict[str, Callable[[Word], None]]:
        handlers: dict[str, Callable[[Word], None]] = {
            "mpm3": self._title,
            "grid": self._grid,
            "fixe": self._faces,
            "mate": self._materials,
            "seos": self._eos,
            "part": self._particles,
            "velo": self._velocities,
            "load": self._loads,
            "cont": self._contact,
            "deto": lambda word: self.state.detonations.append(self.vector(word, "length")),
            "gimp": lambda word: self._shape("gimp"),
            "bimp": lambda word: self._shape("quadratic-bspline"),
            "outr": self._output,
            "curv": self._output,
            "curx": self._output,
            "pt2d": lambda word: self._ignored(word, self.numbers(word, *LENGTHS)),
            "tecp": self._ignored,
            "para": self._ignored,
            "rptt": lambda word: self._ignored(word, self.numbers(word, "time")),
        }
        for key in ("nbmp", "nmat", "nbco", "ncom", "nbbo", "nbgn", "ppc", "tste", "oste"):
            handlers[key] = self._count
        settings: dict[str, tuple[Quantity, ...]] = {
            "spx": ("length", "length"),
            "spy": ("length", "length"),
            "spz": ("length", "length"),
            "dcel": ("length",),
            "dt": ("time",),
            "endt": ("time",),
            "outt": ("time",),
            "dtsc": ("number",),
            "bulk": ("number", "number"),
        }
        for key, kinds in settings.items():
            handlers[key] = self._setting(kinds)
        for key in ("musl", "usf", "usl", "jaum"):
            handlers[key] = self._switch
        return handlers

    # Macros

    def _title(self, word: Word) -> None:
        self.state.title = " ".join(each.text for each in self.on_line(word.line))[:200]
        self.at += len(self.on_line(word.line))

    def _count(self, word: Word) -> None:
        most = {"nbmp": MOST_PARTICLES, "nbgn": MOST_NODES, "ppc": 216}.get(word.key, 1_000_000_000)
        most = 100_000 if word.key in ("nmat", "nbco", "ncom", "nbbo") else most
        self.state.counts[word.key] = self.integer(word, word.text, 1, most), word.line

    def _setting(self, kinds: tuple[Quantity, ...]) -> Callable[[Word], None]:
        def read(word: Word) -> None:
            self.state.numbers[word.key] = self.numbers(word, *kinds)

        return read

    def _grid(self, word: Word) -> None:
        for key in ("spx", "spy", "spz"):
            self.state.numbers[key] = self.numbers(word, "length", "length")

    def _faces(self, word: Word) -> None:
        names = ("x0", "xn", "y0", "yn", "z0", "zn")
        self.state.faces = [self.integer(word, f"boundary {name}", 0, 2) for name in names]

    def _switch(self, word: Word) -> None:
        choice = self.word(word, "on or off")
        if choice.key not in ("on", "off"):
            refuse_line(choice.line, repr(choice.text), "on or off", "write on or off")
        self.state.switches[word.key] = choice.key == "on"

    def _shape(self, name: str) -> None:
        self.state.shape = name

    def _ignored(self, word: Word, _: Any = None) -> None:
        self.state.unused.append(f"{word.text} (line {word.line})")

    def _output(self, word: Word) -> None:
        option = self.word(word, "a quantity to write")
        if option.key not in OPTIONS:
            refuse_line(option.line, repr(option.text), "a quantity to write", nearest_cure(option.key, OPTIONS))
        if word.key == "curx":
            self.vector(word, "length")
        elif word.key == "curv" and self.on_line(word.line):
            self.integer(word, "a particle", 1, MOST_PARTICLES)
        self._ignored(Word(f"{word.text} {option.text}", word.line))

    def _contact(self, word: Word) -> None:
        method = self.word(word, "on, off or lagr")
        if method.key == "lagr":
            self.state.friction = self.number(word, "number", "friction")
            # Which body's normal counts: here both bodies' surfaces give it.
            self.integer(word, "body of the normal", 0, 100_000)
        elif method.key not in ("on", "off"):
            refuse_line(method.line, repr(method.text), "on, off or lagr", "write contact lagr 0.0 1")
        self.state.switches["cont"] = method.key != "off"

    def _needed(self, key: str, word: Word) -> int:
        """A count that an earlier macro has given."""
        if key not in self.state.counts:
            cure = f"write {key} above it"
            refuse_line(word.line, word.text, f"{key} ({TITLES[key]}) before it", cure)
        return self.state.counts[key][0]

    def _materials(self, word: Word) -> None:
        """Rows until the line that does not begin with a number; number, kind and values."""
        count = self._needed("nmat", word)
        while len(self.state.materials) < count:
            first = self.next(f"material {len(self.state.materials) + 1} of {count}")
            self.at -= 1
            if not INTEGER.fullmatch(first.text):
                refuse_line(
                    first.line,
                    f"{first.text!r} after {len(self.state.materials)} materials",
                    f"the {count} materials of nmat",
                    "add the rows that are missing, or correct nmat",
                )
            number = self.integer(first, "a material", 1, count)
            if number in self.state.materials:
                refuse_line(first.line, f"material {number} twice", "each material once", "renumber it")
            self.state.materials[number] = self._material(first)

    def _material(self, first: Word) -> DeckMaterial:
        kind = self.word(first, "a kind of material")
        if kind.key not in KINDS:
            refuse_line(kind.line, repr(kind.text), "a kind of material", nearest_cure(kind.key, KINDS))
        forms = KINDS[kind.key]
        if not forms:
            limit, cure = "a material that this solver has", "choose another kind"
            refuse_line(kind.line, repr(kind.text), limit, cure)
        count = len(self.on_line(first.line))
        form = next((form for form in forms if len(form) == count), None)
        if form is None:
            wanted = " or ".join(f"{len(form)} ({', '.join(form)})" for form in forms)
            limit = f"{wanted} numbers of {kind.text}"
            refuse_line(first.line, f"{count} numbers", limit, "complete or shorten the line")
        values = {name: self.number(first, quantity, name) for name, quantity in form.items()}
        return DeckMaterial(kind.key, values, first.line)

    def _eos(self, word: Word) -> None:
        number = self.integer(word, "a material", 1, max(self._needed("nmat", word), 1))
        form = self.integer(word, "a form of equation of state", 1, 3)
        count = len(self.on_line(word.line))
        names = {(form, count): name for name, form, count in EOS_COUNTS}
        if (form, count) not in names:
            counts = [str(n) for _, each, n in EOS_COUNTS if each == form]
            limit = f"{' or '.join(counts)} numbers of form {form}"
            refuse_line(word.line, f"{count} numbers", limit, "complete or shorten the line")
        if number not in self.state.materials:
            limit, cure = "a material that was read before", "write seos below material"
            refuse_line(word.line, f"material {number}", limit, cure)
        name = names[form, count]
        values = self.numbers(word, *EOS_COUNTS[name, form, count])
        material = self.state.materials[number]
        self.state.materials[number] = DeckMaterial(material.kind, material.values, material.line, name, values)

    def _particles(self, word: Word) -> None:
        most = self._needed("nbmp", word)
        materials = self._needed("nmat", word)
        here = self.on_line(word.line)
        if not here:
            self._table(word, most, materials)
            return
        shape = self.word(word, "point, block, sphere, blod or cicle")
        component = self.integer(word, "a component", 1, 100_000)
        if shape.key == "poin":
            self._points(word, component, most, materials)
            return
        if shape.key not in ("bloc", "sphe", "blod", "cicl"):
            cure = nearest_cure(shape.key, ("point", "block", "sphere", "blod", "cicle"))
            refuse_line(shape.line, repr(shape.text), "point, block, sphere, blod or cicle", cure)
        self._lattice(shape, component, most, materials)

    def _lattice(self, shape: Word, component: int, most: int, materials: int) -> None:
        """The line below: material, density, spacing, origin and counts."""
        row = self._row(f"the line of {shape.text}")
        material = self.integer(row, "a material", 1, materials)
        # Its unit follows from what it turns out to be: read as text twice.
        at = self.at
        density = self.number(row, "density", "density")
        self.at = at
        mass = self.number(row, "mass", "mass of a particle")
        spacing = self.number(row, "length", "spacing of the particles")
        if spacing <= 0.0:
            refuse_line(row.line, f"a spacing of {spacing:g} m", "more than 0", "correct the spacing")
        origin = self.vector(row, "length")
        names = ("nx", "ny", "nz") if shape.key in ("bloc", "blod") else ("nRadius",)
        counts = [self.integer(row, name, 1, MOST_PARTICLES) for name in names]
        hole = (0.0, 0.0, 0.0)
        if shape.key == "blod":
            x, y, _ = self.vector(row, "length")
            hole = (x, y, self.integer(row, "nr", 1, MOST_PARTICLES) * spacing)
        nx, ny, nz = counts * 3 if len(counts) == 1 else counts
        lattice = Lattice(shape.key, spacing, origin, (nx, ny, nz), hole)
        count = self._counted(lattice, row.line, most)
        each = self._particle_mass(row.line, material, density, mass, spacing)
        self.state.bodies.append(
            DeckBody(component, material, row.line, lattice, each, count=count, first=self.state.read - count + 1)
        )

    def _row(self, expected: str) -> Word:
        """The first word of the next line, which is read again."""
        word = self.next(expected)
        self.at -= 1
        return word

    def _counted(self, lattice: Lattice, line: int, most: int) -> int:
        """Particles of a lattice, after a look at how many there can be."""
        left = most - self.state.read
        if least_count(lattice) > left:
            refuse_line(
                line,
                f"{lattice.counts[0]} x {lattice.counts[1]} x {lattice.counts[2]} of {lattice.shape}",
                f"at most the {left} particles that nbmp leaves",
                "correct the counts, or nbmp",
            )
        count = count_of(lattice)
        if not count:
            limit, cure = "a body of one particle at least", "shrink the hole"
            refuse_line(line, "no particle", limit, cure)
        self._add(count, line, most)
        return count

    def _add(self, count: int, line: int, most: int) -> None:
        self.state.read += count
        if self.state.read > most:
            cure = "correct nbmp, or remove particles"
            refuse_line(line, f"particle {self.state.read}", f"the {most} particles of nbmp", cure)

    def _particle_mass(self, line: int, material: int, density: float, mass: float, spacing: float) -> float:
        """The mass of a particle from a number that is a density, or a mass already."""
        if material not in self.state.materials:
            limit, cure = "materials above particles", "write material above it"
            refuse_line(line, f"material {material}", limit, cure)
        own = self.state.materials[material].values["density"]
        expected = own * spacing**3
        if abs(density - own) <= DENSITY_OR_MASS * own:
            return density * spacing**3
        if abs(mass - expected) <= DENSITY_OR_MASS * expected:
            return mass
        limit = (
            f"the density of material {material}, {own:g} kg/m3, or the mass of a particle, {expected:g} kg, within "
            f"{DENSITY_OR_MASS:.0%}"
        )
        refuse_line(line, f"{density:g} kg/m3", limit, "correct the third number or the spacing")

    def _points(self, word: Word, component: int, most: int, materials: int) -> None:
        """Rows of number, material, mass and place."""
        count = self.integer(word, "particles of this body", 1, most)
        rows: list[tuple[int, float, float, float, float]] = []
        first = 0
        for _ in range(count):
            row = self._row(f"particle {len(rows) + 1} of {count}")
            self.integer(row, "a particle", 1, most)
            material = self.integer(row, "a material", 1, materials)
            first = first or material
            if material != first:
                limit, cure = f"material {first} in all of a body", "part it into two bodies"
                refuse_line(row.line, f"material {material}", limit, cure)
            mass = self.number(row, "mass", "mass of the particle")
            self._add(1, row.line, most)
            # MPM3D-F90 counts, whatever number the row has.
            rows.append((self.state.read, *self.vector(row, "length"), mass))
        self.state.bodies.append(DeckBody(component, first, word.line, rows=tuple(rows), count=count))

    def _table(self, word: Word, most: int, materials: int) -> None:
        """The thesis' table: number, material, component and place of all particles."""
        bodies: dict[tuple[int, int], list[tuple[int, float, float, float, float]]] = {}
        for index in range(most):
            row = self._row(f"particle {index + 1} of the {most} of nbmp")
            number = self.integer(row, "a particle", 1, most)
            if number != index + 1:
                limit, cure = f"number {index + 1}", "number the particles from 1 without gaps"
                refuse_line(row.line, f"particle {number}", limit, cure)
            material = self.integer(row, "a material", 1, materials)
            component = self.integer(row, "a component", 1, 100_000)
            place = self.vector(row, "length")
            bodies.setdefault((component, material), []).append((number, *place, 0.0))
            self._add(1, row.line, most)
        for (component, material), rows in bodies.items():
            self.state.bodies.append(DeckBody(component, material, word.line, rows=tuple(rows), count=len(rows)))

    def _velocities(self, word: Word) -> None:
        scopes = {"comp": "component", "body": "body", "node": "particle", "endv": ""}
        while True:
            scope = self.next("endv, the end of the velocities")
            if scope.key not in scopes:
                cure = nearest_cure(scope.key, scopes)
                refuse_line(scope.line, repr(scope.text), "comp, body, node or endv", cure)
            if scope.key == "endv":
                return
            number = self.integer(scope, f"a {scopes[scope.key]}", 1, MOST_PARTICLES)
            velocity = self.vector(scope, "velocity")
            self.state.velocities.append(DeckVelocity(scopes[scope.key], number, velocity, scope.line))

    def _loads(self, word: Word) -> None:
        """Gravity of bodies up to ``endl``."""
        while True:
            scope = self.next("endl, the end of the loads")
            if scope.key == "endl":
                return
            if scope.key != "grav":
                cure = "remove it: forces on bodies and particles are not computed"
                refuse_line(scope.line, repr(scope.text), "grav or endl", cure)
            body = self.integer(scope, "a body", 1, MOST_PARTICLES)
            acceleration = self.vector(scope, "acceleration")
            self.state.gravity.append(DeckGravity(body, acceleration, scope.line))
