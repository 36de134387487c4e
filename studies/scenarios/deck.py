"""A deck of MPM3D: the input file of the thesis' program or of MPM3D-F90 as a scenario.

The parameter ``deck`` is the text of the file, so that a run's identity is its content and no path; the problem is
built from it alone. Its materials, numerics and end are the deck's unless a parameter says otherwise, and what is
measured is what every problem has: energies, momentum, largest pressure, each with its history, and the film.
"""

import math
from dataclasses import dataclass, replace
from typing import Annotated, Any, Literal

from solver.units import Described, Dimensionless, Second
from studies.scenarios import Materials, ObservationRate, ObserverOptions, Scenario, Setting, Size
from studies.scenarios._deck import MOST_BYTES, read_deck
from studies.scenarios._deck_problem import fixed_step, particles_per_cell, problem_of, signal_speed
from studies.scenarios._deck_records import Deck
from studies.scenarios._numerics import BY_RECIPE, Numerics, check_numerics, filled_from, mean_step, tensions
from studies.values.errors import Finding
from studies.values.parameters import Choice, LongText
from studies.values.quantities import round_quantity
from studies.values.recipes import RECIPES, RecipeName

OBSERVATIONS = 20
MOST_OBSERVATIONS = 1000


@dataclass(frozen=True, kw_only=True)
class _DeckText:
    """The deck and its end."""

    deck: Annotated[str, LongText(MOST_BYTES), Described("text of the input file, at most 1 MB of UTF-8")]
    units: Annotated[
        Literal["deck", "mm-g-ms", "SI"],
        Described("units of the deck: those that its comment names, by default mm, g and ms"),
    ] = "deck"
    end_time: Annotated[Second | None, Described("end of the run; by default the deck's", 1e-15, 1e6)] = None
    refinement: Annotated[
        int, Described("grid cells along the edge of a cell of the deck; particles are parted alike", 1, 32)
    ] = 1
    step: Annotated[
        Literal["deck", "stable"], Described("the deck's constant time step, or the stable one of the solver")
    ] = "deck"


@dataclass(frozen=True, kw_only=True)
class DeckRun(Numerics, _DeckText):
    """Parameters of a deck."""

    keeps_particles = True

    recipe: Annotated[RecipeName, Described("preset for what neither the deck nor a parameter says", label=True)] = (
        "thesis"
    )
    contact: Annotated[
        Literal["deck", "none", "bardenhagen", "thesis", "gap"],
        Described("contact between components as the deck says, none, or on the nodes"),
    ] = "deck"  # type: ignore[assignment]
    friction: Annotated[
        Dimensionless | None, Described("Coulomb friction of components in contact; by default the deck's", 0.0, 10.0)
    ] = None  # type: ignore[assignment]
    particles_per_cell: Annotated[
        int | None,
        Described(
            "particles per cell along each direction, for the size of those of gimp; by default the deck's",
            1,
            6,
            acts=lambda parameters: parameters.shape == "gimp",
        ),
    ] = None
    tension: Annotated[
        str | None,
        Choice(tensions),
        Described(
            f"rule for the lowest pressure that soil sustains; {BY_RECIPE}",
            acts=lambda parameters: _has_soil(deck_of(parameters)),
        ),
    ] = None


def deck_of(parameters: DeckRun) -> Deck:
    """What the reader understood; raises InvalidInput."""
    return read_deck(parameters.deck, parameters.units)


def _has_soil(deck: Deck) -> bool:
    return any(material.kind == "dpm" for material in deck.materials.values())


def _end_time(parameters: DeckRun) -> float:
    return parameters.end_time or deck_of(parameters).end_time


def _fill(parameters: DeckRun) -> DeckRun:
    deck = deck_of(parameters)
    quadratic, linear = deck.viscosity
    preset = replace(
        RECIPES[parameters.recipe],
        shape=deck.shape,
        scheme=deck.scheme,
        particles_per_cell=particles_per_cell(deck),
        viscosity_quadratic=quadratic,
        viscosity_linear=linear,
    )
    units: Any = deck.units
    contact: Any = parameters.contact
    if contact == "deck":
        contact = "bardenhagen" if deck.contact else "none"
    friction = parameters.friction
    if friction is None:
        friction = deck.friction if contact != "none" else 0.0
    step = parameters.fixed_dt
    if step is None and parameters.step == "deck":
        step = round_quantity(fixed_step(deck) / parameters.refinement)
    return replace(
        filled_from(parameters, preset),
        units=units,
        contact=contact,
        jaumann=parameters.jaumann and deck.jaumann,
        friction=friction,
        fixed_dt=step,
        end_time=round_quantity(_end_time(parameters)),
    )


def _check(parameters: DeckRun, materials: Materials) -> list[Finding]:
    findings = check_numerics(parameters)
    if parameters.step == "stable" and parameters.fixed_dt is not None:
        limit = "no fixed_dt with the stable step"
        cure = "leave fixed_dt out, or step"
        findings.append(Finding("fixed_dt", f"{parameters.fixed_dt:g} s", limit, cure))
    deck = deck_of(parameters)
    components = {body.component for body in deck.bodies}
    mixed = [
        name
        for name in sorted(components)
        if len({body.material for body in deck.bodies if body.component == name}) > 1
    ]
    if parameters.contact != "none" and mixed:
        limit = f"one material in each component, where bodies have contact: not in component {mixed[0]}"
        findings.append(Finding("contact", parameters.contact, limit, "set contact to none"))
    return findings


def _build(parameters: DeckRun, materials: Materials) -> Setting:
    problem = problem_of(
        deck_of(parameters), parameters, end_time=_end_time(parameters), refinement=parameters.refinement
    )
    return Setting(problem=problem, sector=2.0 * math.pi)


def _size(parameters: DeckRun, materials: Materials) -> Size:
    deck = deck_of(parameters)
    sound = max(signal_speed(material) for material in deck.materials.values()) or 1.0
    speeds = [math.hypot(*each.velocity) for each in deck.velocities]
    fallen = math.hypot(*deck.gravity) * _end_time(parameters)
    speed = max([*speeds, 1e-9 * sound]) + fallen
    fine = parameters.refinement
    dt = parameters.fixed_dt
    if dt is None:
        dt = mean_step(_fill(parameters), deck.cell / fine, sound=sound, speed=speed)
    return Size(particles=deck.particles * fine**3, steps=math.ceil(_end_time(parameters) / dt))


def _cells(parameters: DeckRun) -> dict[str, float]:
    return {"refinement": float(parameters.refinement)}


def _rate(parameters: Any, setting: Setting) -> ObservationRate:
    end = setting.problem.end_time
    asked = deck_of(parameters).output_interval or end / OBSERVATIONS
    return ObservationRate(interval=min(max(asked, end / MOST_OBSERVATIONS), 0.5 * end))


def _view(setting: Any, snapshot: Any) -> Any:
    from studies.measurements import _whole

    return _whole.view(setting, snapshot)


SCENARIO = Scenario(
    name="deck",
    title="Deck of MPM3D",
    description="An input file of the thesis' MPM3D or of MPM3D-F90; energies, momentum and pressure are measured.",
    parameters=DeckRun,
    materials=(),
    measurements=("kinetic_energy", "internal_energy", "momentum_x", "momentum_y", "momentum_z", "largest_pressure"),
    settles=(),
    fill=_fill,
    check=_check,
    build=_build,
    estimate=_size,
    cells=_cells,
    observer=ObserverOptions(rate=_rate, view=_view),
)
