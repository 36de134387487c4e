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

Sizes are compared with limits before anything of that size is made: a deck is at most 2 MB and 20 million particles.
"""

import re
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import lru_cache
from typing import NoReturn

from studies.decks.checks import count_of, finished, least_count
from studies.decks.deck import (
    MOST_PARTICLES,
    Deck,
    DeckBody,
    DeckGravity,
    DeckMaterial,
    DeckState,
    DeckVelocity,
    Lattice,
    ParticleRow,
    Units,
    refuse_line,
)
from studies.decks.macros import COUNTS, EOS_COUNTS, IGNORED, KINDS, OPTIONS, REFUSED, SETTINGS, SHAPES, TITLES
from studies.decks.words import INTEGER, SEPARATORS, DeckWord, Words
from studies.quantities.findings import Finding, InvalidInput, nearest_cure
from studies.quantities.texts import decoded

MOST_BYTES = 2_000_000
BEGINNING = 65_536  # bytes of a larger file that tell what it is
UNREAD = "\ufffd"  # in the place of a byte that is no text
DENSITY_OR_MASS = 0.01  # relative: what a block's third number must agree with
# What is looked at for the words of another program: lines, without empty ones, and characters of a line.
MOST_LINES, LONGEST_LINE = 100, 200
# Input files of other programs, by what begins a line of theirs and of no deck of MPM3D. Abaqus after LS-DYNA, which
# has keywords of its own.
SIGNATURES: Mapping[str, str] = {
    "an LS-DYNA keyword file": r"\*(KEYWORD\b|(PART|SECTION|MAT|CONTROL|ELEMENT|DATABASE|EOS|INITIAL)_[A-Z_]+)",
    "an Abaqus input file": r"\*(HEADING|NODE|ELEMENT|PART|MATERIAL|STEP|ASSEMBLY|INCLUDE|PREPRINT)\b(,|\s*$)",
    "an input file of CTH": r"\*eor\*",
    "a Nastran bulk data file": r"(BEGIN +BULK|SOL +\d+|CEND)\b",
    "a Radioss starter file": r"#RADIOSS\b|/BEGIN\b",
    "an Ansys input file": r"/(PREP7|BATCH|COM\b|FILNAME)",
    "an input file of Autodyn": r"\W*AUTODYN\b",
    "an input file of LAMMPS": r"(atom_style|pair_style|units +(lj|real|metal|si|cgs))\b",
    "an input file of iSALE": r"#ISINP\b",
    "a mesh of Gmsh": r"\$MeshFormat",
    "a VTK file": r"# vtk DataFile|<VTKFile",
}


def read_file_text(content: bytes) -> str:
    """The text of a deck's file, whose comments may be in any encoding.

    Raises InvalidInput for a file of another program, what is no text, with its line, and more than 2 MB.
    """
    if len(content) > MOST_BYTES:
        check_program(content[:BEGINNING].decode("utf-8", "replace"))
        _refuse_size(len(content))
    try:
        return decoded(content, "deck")
    except InvalidInput:
        text = content.decode("utf-8", "replace")
        if any(UNREAD in line.partition("!")[0] for line in text.splitlines()):
            raise
        return text


def check_program(text: str) -> None:
    """Raise InvalidInput for the beginning of a file of another program, named."""
    lines = [line.strip()[:LONGEST_LINE] for line in text[: MOST_LINES * LONGEST_LINE].splitlines()]
    for line in [line for line in lines if line][:MOST_LINES]:
        if line.lower().startswith("mpm3"):
            return
        for program, signature in SIGNATURES.items():
            if re.match(signature, line, re.IGNORECASE):
                cure = "write the problem as a deck of MPM3D, or as a scenario: docs/decks.md"
                raise InvalidInput([Finding("deck", program, "whipple reads decks of MPM3D", cure)])


def read_deck(text: str, units: str = "deck") -> Deck:
    """The deck of a text, in the units that it names or in others; raises InvalidInput with line and cure."""
    if len(text) > MOST_BYTES or len(text.encode()) > MOST_BYTES:
        _refuse_size(len(text.encode()))
    check_program(text)
    read = _read(text, _named_units(text) if units == "deck" else "SI" if units == "SI" else "mm-g-ms")
    if isinstance(read, InvalidInput):
        raise InvalidInput(read.findings)
    return read


@lru_cache(maxsize=4)
def _read(text: str, units: Units) -> Deck | InvalidInput:
    """A deck, or why it is refused: a text is read once for all that ask for it."""
    try:
        return _Reader(text, units).deck()
    except InvalidInput as error:
        return error.with_traceback(None)


def _named_units(text: str) -> Units:
    """The units that a comment names."""
    for number, line in enumerate(text.splitlines(), 1):
        found = re.search(r"!\s*units?\s*[:=]\s*(.*)", line, re.IGNORECASE) if "!" in line else None
        if found:
            names = set(SEPARATORS.split(found[1].strip().lower()))
            if {"mm", "g", "ms"} <= names:
                return "mm-g-ms"
            if {"m", "kg", "s"} <= names:
                return "SI"
            limit, cure = "mm g N ms MPa, or m kg N s Pa", "set units to mm-g-ms or SI"
            refuse_line(number, found[1].strip()[:60], limit, cure)
    return "mm-g-ms"


def _refuse_size(size: int) -> NoReturn:
    cure = "give blocks and spheres in the place of points, or fewer particles"
    raise InvalidInput([Finding("deck", f"{size} bytes", f"at most {MOST_BYTES} bytes", cure)])


class _Reader(Words):
    """One deck being read."""

    def __init__(self, text: str, units: Units):
        super().__init__(text)
        self.units = units
        self.state = DeckState()

    def deck(self) -> Deck:
        """Read all macros up to ``endi``."""
        handlers = self._handlers()
        while True:
            word = self.next("endi, the end of the deck")
            if word.key == "endi":
                return finished(self.state, self.units, word.line)
            if word.key in REFUSED:
                word.refuse(*REFUSED[word.key], word.text)
            if word.key not in handlers:
                word.refuse("a macro of MPM3D", nearest_cure(word.key, handlers), f"the macro {word.text!r}")
            handlers[word.key](word)

    def _handlers(self) -> dict[str, Callable[[DeckWord], None]]:
        return {
            **dict.fromkeys(COUNTS, self._count),
            **dict.fromkeys(SETTINGS, self._setting),
            **dict.fromkeys(("musl", "usf", "usl", "jaum"), self._switch),
            **dict.fromkeys(SHAPES, self._shape),
            **dict.fromkeys(("outr", "curv", "curx"), self._output),
            **dict.fromkeys(IGNORED, self._ignored),
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
        }

    # Macros

    def _title(self, word: DeckWord) -> None:
        self.state.title = " ".join(follower.text for follower in self.on_line(word.line))[:200]
        self.at += len(self.on_line(word.line))

    def _count(self, word: DeckWord) -> None:
        self.state.counts[word.key] = self.integer(word, word.text, 1, COUNTS[word.key]), word.line

    def _setting(self, word: DeckWord) -> None:
        self.state.numbers[word.key] = self.numbers(word, *SETTINGS[word.key])

    def _grid(self, word: DeckWord) -> None:
        for key in ("spx", "spy", "spz"):
            self.state.numbers[key] = self.numbers(word, *SETTINGS[key])

    def _faces(self, word: DeckWord) -> None:
        names = ("x0", "xn", "y0", "yn", "z0", "zn")
        self.state.faces = [self.integer(word, f"boundary {name}", 0, 2) for name in names]

    def _switch(self, word: DeckWord) -> None:
        choice = self.chosen(self.word(word, "on or off"), "on or off", ("on", "off"), "write on or off")
        self.state.switches[word.key] = choice.key == "on"

    def _shape(self, word: DeckWord) -> None:
        self.state.shape = SHAPES[word.key]

    def _ignored(self, word: DeckWord) -> None:
        self.numbers(word, *IGNORED.get(word.key, ()))
        self.state.unused.append(f"{word.text} (line {word.line})")

    def _output(self, word: DeckWord) -> None:
        limit = "a quantity to write"
        option = self.chosen(self.word(word, limit), limit, OPTIONS)
        if word.key == "curx":
            self.vector(word, "length")
        elif word.key == "curv" and self.on_line(word.line):
            self.integer(word, "a particle", 1, MOST_PARTICLES)
        self.state.unused.append(f"{word.text} {option.text} (line {word.line})")

    def _contact(self, word: DeckWord) -> None:
        limit = "on, off or lagr"
        method = self.chosen(self.word(word, limit), limit, ("on", "off", "lagr"), "write contact lagr 0.0 1")
        if method.key == "lagr":
            self.state.friction = self.number(word, "number", "friction")
            # Which body's normal counts: here both bodies' surfaces give it.
            self.integer(word, "body of the normal", 0, 100_000)
        self.state.switches["cont"] = method.key != "off"

    def _needed(self, key: str, word: DeckWord) -> int:
        """A count that an earlier macro has given."""
        if key not in self.state.counts:
            word.refuse(f"{key} ({TITLES[key]}) before it", f"write {key} above it", word.text)
        return self.state.counts[key][0]

    def _materials(self, word: DeckWord) -> None:
        """Rows until the line that does not begin with a number; number, kind and values."""
        count, materials = self._needed("nmat", word), self.state.materials
        while len(materials) < count:
            first = self.peek(f"material {len(materials) + 1} of {count}")
            if not INTEGER.fullmatch(first.text):
                value = f"{first.text!r} after {len(materials)} materials"
                first.refuse(f"the {count} materials of nmat", "add the rows that are missing, or correct nmat", value)
            number = self.integer(first, "a material", 1, count)
            if number in materials:
                first.refuse("each material once", "renumber it", f"material {number} twice")
            materials[number] = self._material(first)

    def _material(self, first: DeckWord) -> DeckMaterial:
        kind = self.chosen(self.word(first, "a kind of material"), "a kind of material", KINDS)
        forms = KINDS[kind.key]
        if not forms:
            kind.refuse("a material that this solver has", "choose another kind", repr(kind.text))
        count = len(self.on_line(first.line))
        form = next((form for form in forms if len(form) == count), None)
        if form is None:
            wanted = " or ".join(f"{len(form)} ({', '.join(form)})" for form in forms)
            first.refuse(f"{wanted} numbers of {kind.text}", "complete or shorten the line", f"{count} numbers")
        values = {name: self.number(first, quantity, name) for name, quantity in form.items()}
        return DeckMaterial(kind.key, values, first.line)

    def _eos(self, word: DeckWord) -> None:
        number = self.integer(word, "a material", 1, max(self._needed("nmat", word), 1))
        form = self.integer(word, "a form of equation of state", 1, 3)
        count = len(self.on_line(word.line))
        names = {(form, count): name for name, form, count in EOS_COUNTS}
        if (form, count) not in names:
            counts = " or ".join(str(n) for _, stated, n in EOS_COUNTS if stated == form)
            word.refuse(f"{counts} numbers of form {form}", "complete or shorten the line", f"{count} numbers")
        if number not in self.state.materials:
            word.refuse("a material that was read before", "write seos below material", f"material {number}")
        name = names[form, count]
        values = self.numbers(word, *EOS_COUNTS[name, form, count])
        self.state.materials[number] = replace(self.state.materials[number], eos=name, eos_values=values)

    def _particles(self, word: DeckWord) -> None:
        most, materials = self._needed("nbmp", word), self._needed("nmat", word)
        if not self.on_line(word.line):
            self._table(word, most, materials)
            return
        names = ("point", "block", "sphere", "blod", "cicle")
        limit = f"{', '.join(names[:-1])} or {names[-1]}"
        shape = self.word(word, limit)
        component = self.integer(word, "a component", 1, 100_000)
        if shape.key == "poin":
            self._points(word, component, most, materials)
            return
        if shape.key not in [name[:4] for name in names]:
            shape.refuse(limit, nearest_cure(shape.key, names), repr(shape.text))
        self._lattice(shape, component, most, materials)

    def _lattice(self, shape: DeckWord, component: int, most: int, materials: int) -> None:
        """The line below: material, density, spacing, origin and counts."""
        row = self.peek(f"the line of {shape.text}")
        material = self.integer(row, "a material", 1, materials)
        # Its unit follows from what it turns out to be: read as text twice.
        at = self.at
        density = self.number(row, "density", "density")
        self.at = at
        mass = self.number(row, "mass", "mass of a particle")
        spacing = self.number(row, "length", "spacing of the particles")
        if spacing <= 0.0:
            row.refuse("more than 0", "correct the spacing", f"a spacing of {spacing:g} m")
        origin = self.vector(row, "length")
        names = ("nx", "ny", "nz") if shape.key in ("bloc", "blod") else ("nRadius",)
        counts = [self.integer(row, name, 1, MOST_PARTICLES) for name in names]
        hole = (0.0, 0.0, 0.0)
        if shape.key == "blod":
            x, y, _ = self.vector(row, "length")
            hole = (x, y, self.integer(row, "nr", 1, MOST_PARTICLES) * spacing)
        nx, ny, nz = counts * 3 if len(counts) == 1 else counts
        lattice = Lattice(shape.key, spacing, origin, (nx, ny, nz), hole)
        count = self._counted(lattice, row, most)
        own = self._particle_mass(row, material, density, mass, spacing)
        first = self.state.read - count + 1
        self.state.bodies.append(DeckBody(component, material, row.line, lattice, own, count=count, first=first))

    def _counted(self, lattice: Lattice, row: DeckWord, most: int) -> int:
        """Particles of a lattice, after a look at how many there can be."""
        left = most - self.state.read
        if least_count(lattice) > left:
            value = f"{' x '.join(map(str, lattice.counts))} of {lattice.shape}"
            row.refuse(f"at most the {left} particles that nbmp leaves", "correct the counts, or nbmp", value)
        count = count_of(lattice)
        if not count:
            row.refuse("a body of one particle at least", "shrink the hole", "no particle")
        self._add(count, row, most)
        return count

    def _add(self, count: int, row: DeckWord, most: int) -> None:
        self.state.read += count
        if self.state.read > most:
            cure = "correct nbmp, or remove particles"
            row.refuse(f"the {most} particles of nbmp", cure, f"particle {self.state.read}")

    def _particle_mass(self, row: DeckWord, material: int, density: float, mass: float, spacing: float) -> float:
        """The mass of a particle from a number that is a density, or a mass already."""
        if material not in self.state.materials:
            row.refuse("materials above particles", "write material above it", f"material {material}")
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
        row.refuse(limit, "correct the third number or the spacing", f"{density:g} kg/m3")

    def _points(self, word: DeckWord, component: int, most: int, materials: int) -> None:
        """Rows of number, material, mass and place."""
        count = self.integer(word, "particles of this body", 1, most)
        rows: list[ParticleRow] = []
        first = 0
        for _ in range(count):
            row = self.peek(f"particle {len(rows) + 1} of {count}")
            self.integer(row, "a particle", 1, most)
            material = self.integer(row, "a material", 1, materials)
            first = first or material
            if material != first:
                row.refuse(f"material {first} in all of a body", "part it into two bodies", f"material {material}")
            mass = self.number(row, "mass", "mass of the particle")
            self._add(1, row, most)
            # MPM3D-F90 counts, whatever number the row has.
            rows.append((self.state.read, *self.vector(row, "length"), mass))
        self.state.bodies.append(DeckBody(component, first, word.line, rows=tuple(rows), count=count))

    def _table(self, word: DeckWord, most: int, materials: int) -> None:
        """The thesis' table: number, material, component and place of all particles."""
        bodies: dict[tuple[int, int], list[ParticleRow]] = {}
        for index in range(1, most + 1):
            row = self.peek(f"particle {index} of the {most} of nbmp")
            number = self.integer(row, "a particle", 1, most)
            if number != index:
                row.refuse(f"number {index}", "number the particles from 1 without gaps", f"particle {number}")
            material = self.integer(row, "a material", 1, materials)
            component = self.integer(row, "a component", 1, 100_000)
            bodies.setdefault((component, material), []).append((number, *self.vector(row, "length"), 0.0))
            self._add(1, row, most)
        for (component, material), rows in bodies.items():
            self.state.bodies.append(DeckBody(component, material, word.line, rows=tuple(rows), count=len(rows)))

    def _velocities(self, word: DeckWord) -> None:
        scopes = {"comp": "component", "body": "body", "node": "particle", "endv": ""}
        while True:
            scope = self.chosen(self.next("endv, the end of the velocities"), "comp, body, node or endv", scopes)
            if scope.key == "endv":
                return
            of = scopes[scope.key]
            number = self.integer(scope, f"a {of}", 1, MOST_PARTICLES)
            self.state.velocities.append(DeckVelocity(of, number, self.vector(scope, "velocity"), scope.line))

    def _loads(self, word: DeckWord) -> None:
        """Gravity of bodies up to ``endl``."""
        cure = "remove it: forces on bodies and particles are not computed"
        while True:
            scope = self.chosen(self.next("endl, the end of the loads"), "grav or endl", ("grav", "endl"), cure)
            if scope.key == "endl":
                return
            body = self.integer(scope, "a body", 1, MOST_PARTICLES)
            self.state.gravity.append(DeckGravity(body, self.vector(scope, "acceleration"), scope.line))
