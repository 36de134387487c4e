"""Decks of MPM3D as a whole: what must be there, fit together and lie within the grid."""

import math
from typing import NoReturn

from studies.decks.deck import (
    MOST_NODES,
    Deck,
    DeckBody,
    DeckGravity,
    DeckMaterial,
    DeckState,
    Lattice,
    Units,
    Vector,
    refuse_line,
)

WHOLE = 1e-6  # of a cell: a span is a whole number of cells
MOST_COLUMNS, MOST_LAYERS = 1_000_000, 20  # of a block with a hole, along z and on average
SPARSEST = 0.3  # of the cube about it, the least that particles of a ball or disc fill


def least_count(lattice: Lattice) -> int:
    """No more particles than a lattice has, without counting them; a hole may take all of a block that is small."""
    nx, ny, nz = lattice.counts
    if lattice.shape == "sphe":
        return int(SPARSEST * (2 * nx) ** 3)
    if lattice.shape == "cicl":
        return int(SPARSEST * (2 * nx) ** 2)
    if lattice.shape == "blod" and max(nx * ny, nx * ny * nz / MOST_LAYERS) <= MOST_COLUMNS:
        return 0
    return nx * ny * nz


def count_of(lattice: Lattice) -> int:
    """Particles of a lattice."""
    import numpy as np  # which takes 0.1 s

    nx, ny, nz = lattice.counts
    if lattice.shape == "bloc":
        return nx * ny * nz
    if lattice.shape == "blod":
        (x0, y0, _), (x1, y1, radius), step = lattice.origin, lattice.hole, lattice.spacing
        across, along = x0 + step * (np.arange(nx) + 0.5) - x1, y0 + step * (np.arange(ny) + 0.5) - y1
        return nz * int((across[:, None] ** 2 + along**2 >= radius * radius).sum())
    squares = (np.arange(nx) + 0.5) ** 2
    # Of the ascending squares along the last axis, those that are below what the other axes leave.
    left = nx * nx - squares if lattice.shape == "cicl" else nx * nx - squares[:, None] - squares
    return (4 if lattice.shape == "cicl" else 8) * int(np.searchsorted(squares, left).sum())


def box_of(body: DeckBody) -> tuple[Vector, Vector]:
    """The corners of the particles' places, m."""
    if body.lattice is None:
        places = list(zip(*(row[1:4] for row in body.rows), strict=True))
        low, high = ([end(axis) for axis in places] for end in (min, max))
        return (low[0], low[1], low[2]), (high[0], high[1], high[2])
    lattice, half = body.lattice, 0.5 * body.lattice.spacing
    ends = []
    for axis, (begin, count) in enumerate(zip(lattice.origin, lattice.counts, strict=True)):
        reach = count * lattice.spacing
        flat = lattice.shape in ("bloc", "blod") or (lattice.shape == "cicl" and axis == 2)
        if lattice.shape == "cicl" and axis == 2:
            reach = lattice.spacing
        ends.append((begin + half if flat else begin - reach + half, begin + reach - half))
    (x0, x1), (y0, y1), (z0, z1) = ends
    return (x0, y0, z0), (x1, y1, z1)


def finished(state: DeckState, units: Units, line: int) -> Deck:
    """The deck of all macros; ``line`` is that of ``endi``."""
    numbers, counts = state.numbers, state.counts
    for key, title in (("spx", "grid"), ("spy", "grid"), ("spz", "grid"), ("dcel", "cell")):
        if key not in numbers:
            refuse_line(line, "endi", f"{key} (the {title}) before it", f"write {key}")
    if not state.bodies:
        refuse_line(line, "endi", "particles before it", "write Particle")
    [cell] = numbers["dcel"]
    if cell <= 0.0:
        refuse_line(line, f"dcell of {cell:g} m", "a cell of more than 0", "correct dcell")
    cells = [_cells(state, axis, cell, line) for axis in range(3)]
    nodes = math.prod(count + 1 for count in cells)
    if nodes > MOST_NODES:
        cure = "choose larger cells, or a smaller grid"
        refuse_line(line, f"{nodes:.3g} nodes", f"at most {MOST_NODES:.3g}", cure)
    _check_counts(state, nodes, line)
    lower = [numbers[key][0] for key in ("spx", "spy", "spz")]
    if state.shape != "linear":  # their closed faces hold the second layer of nodes, and ours the first
        for axis in range(3):
            below, above = (bool(face) for face in state.faces[2 * axis : 2 * axis + 2])
            lower[axis] += below * cell
            cells[axis] -= below + above
            if cells[axis] < 1:
                limit = f"a cell between the closed faces of {'xyz'[axis]}, besides one at each"
                refuse_line(line, f"{cells[axis]} cells", limit, f"enlarge sp{'xyz'[axis]}")
    dt = numbers.get("dt", (None,))[0]
    steps = counts.get("tste", (None, 0))[0]
    end = numbers.get("endt", (dt * steps if dt and steps else None,))[0]
    if end is None or end <= 0.0 or (dt is not None and dt <= 0.0):
        limit = "endt, or dt and tstep, of more than 0"
        refuse_line(line, "no end of the run", limit, "write endtime")
    scale = numbers.get("dtsc", (0.9,))[0]
    if not 0.0 < scale <= 2.5:
        refuse_line(line, f"dtscale {scale:g}", "more than 0, at most 2.5", "correct dtscale")
    output = numbers.get("outt", (None,))[0]
    every = counts.get("oste", (None, 0))[0]
    if output is None and every and dt:
        output = every * dt
    quadratic, linear = numbers.get("bulk", (1.5, 0.06))
    deck = Deck(
        title=state.title,
        units=units,
        lower=(lower[0], lower[1], lower[2]),
        cells=(cells[0], cells[1], cells[2]),
        cell=cell,
        faces=tuple(state.faces),  # type: ignore[arg-type]
        materials=dict(sorted(state.materials.items())),
        bodies=tuple(state.bodies),
        velocities=tuple(state.velocities),
        detonations=tuple(state.detonations),
        gravity=_gravity(state.gravity, len(state.bodies)),
        end_time=end,
        dt=dt,
        step_scale=scale,
        output_interval=output if output and output > 0.0 else None,
        # MUSL by default, as in MPM3D.
        scheme="usf" if state.switches.get("usf") else "usl" if state.switches.get("usl") else "musl",
        shape=state.shape,
        contact=state.switches.get("cont", False),
        jaumann=state.switches.get("jaum", True),
        friction=state.friction,
        viscosity=(quadratic, linear),
        per_cell=counts.get("ppc", (None, 0))[0],
        unused=tuple(state.unused),
    )
    _check_materials(deck)
    _check_bodies(deck)
    _check_velocities(deck)
    return deck


def _cells(state: DeckState, axis: int, cell: float, line: int) -> int:
    """Cells along an axis: those that cover the span; a closed upper face lies where the span ends."""
    name = "xyz"[axis]
    low, high = state.numbers[f"sp{name}"]
    span = (high - low) / cell

    def refuse(limit: str) -> NoReturn:
        refuse_line(line, f"{span:.6g} cells along {name}", limit, f"correct sp{name} or dcell")

    if not 0.5 < span < MOST_NODES:
        refuse(f"sp{name} of one cell at least, and at most {MOST_NODES:.3g}")
    count = round(span)
    if abs(span - count) <= WHOLE * max(span, 1.0):
        return count
    if state.faces[2 * axis + 1]:
        refuse(f"a whole number of cells up to the closed face {name}n")
    return math.ceil(span)


def _gravity(stated: list[DeckGravity], bodies: int) -> Vector:
    """That of all bodies; later lines of the deck overrule earlier ones."""
    by_body = {pull.body: pull for pull in stated}
    for pull in by_body.values():
        if pull.body > bodies:
            refuse_line(pull.line, f"body {pull.body}", "a body of the deck", "correct its number")
    if not by_body:
        return 0.0, 0.0, 0.0
    last = stated[-1]
    if len(by_body) < bodies or any(pull.acceleration != last.acceleration for pull in by_body.values()):
        limit = f"one gravity for all {bodies} bodies"
        refuse_line(last.line, f"gravity of body {last.body} alone", limit, "write grav for each")
    return last.acceleration


def _check_counts(state: DeckState, nodes: int, line: int) -> None:
    """Stated counts are those that were read."""
    components = len({body.component for body in state.bodies})
    got = {"nbmp": state.read, "nbbo": len(state.bodies), "nbgn": nodes, "nbco": components, "ncom": components}
    for key, count in got.items():
        stated, at = state.counts.get(key, (count, line))
        if stated != count:
            cure = f"write {key} {count}, or complete the deck"
            refuse_line(at, f"{key} {stated}", f"the {count} that the deck has", cure)


def _check_materials(deck: Deck) -> None:
    for number, material in deck.materials.items():
        wanted = {"hiex": ("jwl",), "null": ("polynomial",), "dpm": ("",)}
        others = ("", "gruneisen", "polynomial")
        allowed = wanted.get(material.kind, others)
        if material.eos not in allowed:
            names = {"": "no seos", "jwl": "seos 3", "polynomial": "seos 1", "gruneisen": "seos 2"}
            refuse_line(
                material.line,
                f"{material.kind} with {names[material.eos]}",
                " or ".join(names[name] for name in allowed),
                f"correct seos of material {number}",
            )
        _check_values(number, material)
        burning = [body for body in deck.bodies if body.material == number]
        if material.kind == "hiex" and burning and not deck.detonations:
            cure = "write deto x y z"
            refuse_line(material.line, "an explosive without a detonation", "a point of deto", cure)


def _check_values(number: int, material: DeckMaterial) -> None:
    """Limits of the constants that every solver has."""
    values, cure = material.values, f"correct material {number}"
    limits = {"density": (0.0, math.inf), "young": (0.0, math.inf), "D": (0.0, math.inf), "poisson": (-1.0, 0.5)}
    for name, (low, high) in limits.items():
        if name in values and not low < values[name] < high:
            refuse_line(material.line, f"{values[name]:g}", f"{name} between {low:g} and {high:g}", cure)
    for name, value in values.items():
        if value < 0.0 and name not in ("poisson", "room", "melt"):
            refuse_line(material.line, f"{value:g}", f"{name} of 0 or more", cure)
    if values.get("qpsi"):
        limit = "slip without change of volume, qpsi 0"
        refuse_line(material.line, f"qpsi {values['qpsi']:g}", limit, "write 0 for qpsi")
    if values.get("viscosity"):
        refuse_line(material.line, "a viscosity", "a fluid without viscosity", "write 0 for it")
    if "tangent" in values and values["tangent"] >= values["young"]:
        limit = "a tangent modulus below Young's modulus"
        refuse_line(material.line, f"{values['tangent']:g} Pa", limit, cure)


def _check_bodies(deck: Deck) -> None:
    upper = [low + count * deck.cell for low, count in zip(deck.lower, deck.cells, strict=True)]
    for body in deck.bodies:
        for row in body.rows:
            if row[4] < 0.0 or (row[4] == 0.0 and deck.per_cell is None):
                limit = "a mass of more than 0, or ppc for particles without mass"
                refuse_line(body.line, f"particle {row[0]}", limit, "correct it")
        low, high = box_of(body)
        for axis in range(3):
            if low[axis] < deck.lower[axis] or high[axis] >= upper[axis]:
                name = "xyz"[axis]
                reach = f"particles from {low[axis]:g} to {high[axis]:g} m along {name}"
                limit = f"the grid from {deck.lower[axis]:g} to {upper[axis]:g} m"
                refuse_line(body.line, reach, limit, f"enlarge sp{name}, or move the body")
    if deck.contact:
        of: dict[int, int] = {}
        for body in deck.bodies:
            first = of.setdefault(body.component, body.material)
            if first != body.material:
                limit = "one material in each component, where bodies have contact"
                cure = "give the body a component of its own, or leave contact out"
                refuse_line(body.line, f"material {body.material}", limit, cure)


def _check_velocities(deck: Deck) -> None:
    allowed = {
        "component": {body.component for body in deck.bodies},
        "body": range(1, len(deck.bodies) + 1),
        "particle": range(1, deck.particles + 1),
    }
    for given in deck.velocities:
        if given.number not in allowed[given.of]:
            refuse_line(given.line, f"{given.of} {given.number}", f"a {given.of} of the deck", "correct its number")
