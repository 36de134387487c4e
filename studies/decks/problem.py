"""Decks of MPM3D as problems of the solver: matter, bodies, grid, faces."""

import math
from typing import TYPE_CHECKING, NamedTuple

from studies.decks.deck import Deck, DeckBody, DeckMaterial
from studies.scenarios.parts.lattice import points

if TYPE_CHECKING:
    import numpy as np

    from solver.matter.eos import EosRecord
    from solver.matter.laws import Matter
    from solver.problem import Body, Problem

ROOM = 293.0  # K: ``celsius_t`` of MPM3D-F90 at the beginning, Particle.f90
CELSIUS = 273.15  # K
COLDEST = 100.0  # a room temperature of a deck below is one in degrees Celsius
REFERENCE_RATE = 1.0  # 1/s, where a deck gives none: Ma (2005), section 2.1.2


def bulk_modulus(material: DeckMaterial) -> float:
    """K of a material with Young's modulus, Pa."""
    return material.values["young"] / (3.0 * (1.0 - 2.0 * material.values["poisson"]))


def shear_modulus(material: DeckMaterial) -> float:
    """G, Pa; zero of fluids and explosives."""
    if "young" not in material.values:
        return 0.0
    return material.values["young"] / (2.0 * (1.0 + material.values["poisson"]))


def signal_speed(material: DeckMaterial) -> float:
    """The speed from which MPM3D-F90 takes its step (``SetDT``), m/s."""
    values, density = material.values, material.values["density"]
    if "D" in values:
        return values["D"]
    if "wave speed" in values:
        return values["wave speed"]
    if "bulk" in values:
        return math.sqrt(values["bulk"] / density)
    stiffness = bulk_modulus(material) + 4.0 / 3.0 * shear_modulus(material)
    return math.sqrt(stiffness / density)


def fixed_step(deck: Deck) -> float:
    """The constant step that a deck asks for, s."""
    if deck.dt is not None:
        return deck.dt
    fastest = max(signal_speed(material) for material in deck.materials.values())
    if not fastest > 0.0:
        return deck.end_time
    return deck.step_scale * deck.cell / fastest


def particles_per_cell(deck: Deck) -> int:
    """Particles along each direction of a cell, about."""
    step = min(_spacing(deck, body) for body in deck.bodies)
    return min(max(1, round(deck.cell / step)), 6)


def problem_of(deck: Deck, *, tension: str, contact: bool, end_time: float, refinement: int) -> "Problem":
    """The problem of a deck, with the default numerics.

    A refined cell has as many particles as a cell of the deck, each a part of one of the deck's.
    """
    from solver.problem import Face, Problem
    from solver.problem.geometry import Cartesian3D, grid

    faces = [(Face.FREE, Face.FIXED, Face.SYMMETRIC)[face] for face in deck.faces]
    return Problem(
        geometry=grid(
            Cartesian3D,
            lower=deck.lower,
            cells=tuple(count * refinement for count in deck.cells),
            spacing=deck.cell / refinement,
        ),
        bodies=tuple(_bodies(deck, tension, contact, refinement)),
        faces=((faces[0], faces[1]), (faces[2], faces[3]), (faces[4], faces[5])),
        end_time=end_time,
        gravity=deck.gravity,
    )


def matter_of(material: DeckMaterial, tension: str) -> "Matter":
    """The matter of a row of the table of materials."""
    from solver.matter.failure.none import NoFailure
    from solver.matter.failure.plastic_strain import PlasticStrainLimit
    from solver.matter.laws import Matter
    from solver.matter.tension.recoverable import RecoverableTension
    from solver.matter.tension.unlimited import UnlimitedTension

    values = material.values
    room, melt = ROOM, math.inf
    if "melt" in values:
        shift = CELSIUS if values["room"] < COLDEST else 0.0
        room, melt = values["room"] + shift, values["melt"] + shift
    bears = material.kind != "dpm" or tension == "unlimited"
    return Matter(
        eos=_eos(material, room),
        strength=_strength(material),
        tension=UnlimitedTension() if bears else RecoverableTension(_tensile(material)),
        shear_modulus=shear_modulus(material),
        room_temperature=room,
        melt_temperature=melt,
        failure=PlasticStrainLimit(values["epf"]) if "epf" in values else NoFailure(),
    )


def _eos(material: DeckMaterial, room: float) -> "EosRecord":
    from solver.matter.eos.jwl import JonesWilkinsLee
    from solver.matter.eos.linear_elastic import LinearElastic
    from solver.matter.eos.mie_grueneisen_cubic import mie_grueneisen_cubic
    from solver.matter.eos.polynomial import Polynomial

    values, numbers = material.values, material.eos_values
    common: dict[str, float] = {"density": values["density"], "temperature": room}
    if material.eos == "jwl":
        named = dict(zip(("A", "B", "R1", "R2", "omega", "E0"), numbers, strict=True))
        return JonesWilkinsLee(detonation_velocity=values["D"], **common, **named)
    common["heat_capacity"] = values.get("specific heat", math.inf)
    if material.eos == "polynomial":
        named = dict(zip(("C0", "C1", "C2", "C3", "C4", "C5", "C6", "E0"), numbers, strict=True))
        return Polynomial(**common, **named)
    if material.eos == "gruneisen":
        eos: EosRecord = mie_grueneisen_cubic(c0=numbers[0], s=numbers[1], gamma0=numbers[2], **common)
        return eos
    return LinearElastic(bulk_modulus=bulk_modulus(material), **common)


def _strength(material: DeckMaterial) -> NamedTuple:
    from solver.matter.strength.drucker_prager import DruckerPrager
    from solver.matter.strength.elastic import Elastic
    from solver.matter.strength.johnson_cook import JohnsonCook
    from solver.matter.strength.linear_hardening import LinearHardening
    from solver.matter.strength.perfectly_plastic import PerfectlyPlastic

    values = material.values
    if material.kind == "dpm":
        return DruckerPrager(values["kfai"], values["qfai"], _tensile(material))
    if "C" in values:
        return JohnsonCook(
            A=values["yield"],
            B=values["B"],
            n=values["n"],
            C=values["C"],
            m=values.get("m", 1.0),
            reference_rate=values.get("epso", REFERENCE_RATE),
        )
    if "tangent" in values:
        young, tangent = values["young"], values["tangent"]
        return LinearHardening(values["yield"], young * tangent / (young - tangent))
    return PerfectlyPlastic(values["yield"]) if "yield" in values else Elastic()


def _tensile(material: DeckMaterial) -> float:
    """Cut-off of a soil in tension, at the apex of its cone at the latest; zero without friction: MPM3D-F90, M3DM9."""
    cohesion, friction = material.values["kfai"], material.values["qfai"]
    return min(material.values["tenf"], cohesion / friction) if friction > 0.0 else 0.0


def _energy(material: DeckMaterial) -> float:
    """Specific internal energy at the beginning, J/kg: E0 is the last number of each form that has it."""
    has = material.eos in ("jwl", "polynomial") or len(material.eos_values) == 4
    return material.eos_values[-1] / material.values["density"] if has else 0.0


def _spacing(deck: Deck, body: DeckBody) -> float:
    """Edge of the cube that is a particle's, m."""
    if body.lattice is not None:
        return body.lattice.spacing
    density = deck.materials[body.material].values["density"]
    return float((_row_mass(deck, body, 0) / density) ** (1.0 / 3.0))


def _row_mass(deck: Deck, body: DeckBody, row: int) -> float:
    """The mass of a particle, kg: of its row, or the density of its material's share of a cell."""
    stated = body.rows[row][4]
    if stated or deck.per_cell is None:
        return stated
    density = deck.materials[body.material].values["density"]
    return density * deck.cell**3 / deck.per_cell


def _bodies(deck: Deck, tension: str, contact: bool, refinement: int) -> "list[Body]":
    """The bodies; those of a component are one where bodies have contact."""
    import numpy as np

    from solver.matter.eos.jwl import lighting_times
    from solver.problem import Body

    velocities = _velocities(deck)
    groups: dict[int, list[int]] = {}
    for index, body in enumerate(deck.bodies):
        groups.setdefault(body.component if contact else index, []).append(index)
    made = []
    for key, group in groups.items():
        own = [deck.bodies[index] for index in group]
        material = deck.materials[own[0].material]
        spacing = _spacing(deck, own[0])
        position = np.concatenate([_parted(_places(body), _spacing(deck, body), refinement) for body in own])
        parts, burns = refinement**3, material.kind == "hiex"
        made.append(
            Body(
                name=f"component_{key}" if contact else f"body_{key + 1}",
                matter=matter_of(material, tension),
                position=position,
                velocity=np.repeat(np.concatenate([velocities[index] for index in group]), parts, axis=0),
                mass=np.repeat(np.concatenate([_masses(deck, body) for body in own]), parts) / parts,
                density=material.values["density"],
                spacing=(spacing / refinement,) * 3,
                energy=_energy(material),
                lighting=lighting_times(position, material.values["D"], deck.detonations) if burns else None,
            )
        )
    return made


def _parted(places: "np.ndarray", spacing: float, parts: int) -> "np.ndarray":
    """Places (n, 3) of cubes of an edge (m) as those of their parts, so many along each edge."""
    import numpy as np

    if parts == 1:
        return places
    line = spacing * ((np.arange(parts) + 0.5) / parts - 0.5)
    offsets = np.stack([axis.ravel() for axis in np.meshgrid(line, line, line)], axis=-1)
    return (places[:, None, :] + offsets).reshape(-1, 3)


def _masses(deck: Deck, body: DeckBody) -> "np.ndarray":
    import numpy as np

    if body.lattice is not None:
        return np.full(body.count, body.mass)
    return np.array([_row_mass(deck, body, row) for row in range(body.count)])


def _velocities(deck: Deck) -> "list[np.ndarray]":
    """(n, 3) of each body, m/s; later lines of the deck overrule earlier ones."""
    import numpy as np

    speeds = [np.zeros((body.count, 3)) for body in deck.bodies]
    numbers = [
        np.array([row[0] for row in body.rows]) if body.lattice is None else body.first + np.arange(body.count)
        for body in deck.bodies
    ]
    for given in deck.velocities:
        for index, body in enumerate(deck.bodies):
            if given.number == {"component": body.component, "body": index + 1}.get(given.of):
                speeds[index][:] = given.velocity
            elif given.of == "particle":
                speeds[index][numbers[index] == given.number] = given.velocity
    return speeds


def _places(body: DeckBody) -> "np.ndarray":
    """(n, 3) of the particles, m."""
    import numpy as np

    lattice = body.lattice
    if lattice is None:
        return np.array([row[1:4] for row in body.rows])
    n, is_disc = lattice.counts[0], lattice.shape == "cicl"
    if lattice.shape in ("bloc", "blod"):
        lines = [np.arange(count) + 0.5 for count in lattice.counts]
    else:
        across = np.arange(-n, n) + 0.5
        lines = [across, across, np.array([0.5]) if is_disc else across]
    grid = points(*lines)  # from the origin, in spacings
    places: np.ndarray = np.asarray(lattice.origin) + lattice.spacing * grid
    if lattice.shape == "blod":
        away = (places[:, :2] - np.asarray(lattice.hole[:2])) ** 2
        return places[away[:, 0] + away[:, 1] >= lattice.hole[2] * lattice.hole[2]]
    if lattice.shape == "bloc":
        return places
    return places[(grid[:, : 2 if is_disc else 3] ** 2).sum(axis=1) < n**2]
