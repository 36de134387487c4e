"""What a cube may hold: every variable once, with name, dimensions, unit and meaning.

A name in braces stands for a word of the sweep: ``{quantity}`` for each measured quantity
(``hole_diameter``), ``{part}`` for each part of its uncertainty. The dimension ``*`` stands for all
dimensions of the runs, ``@`` for the points that a user asked for: the same without the refinements,
resolution and offset, which are dimensions where a sweep names several. ``cube.build`` makes nothing
that is not declared here, and ``cube.validate`` refuses anything else.

How to add one: a number of the audit is one line of ``NUMBERS``; a quantity comes from its
measurement, a parameter from its scenario, and neither needs an edit here.
"""

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal

from solver.errors import WhippleError
from studies.convergence.richardson import VERDICTS
from studies.values.parameters import Parameter

# 2: refinements and what converges over them; laws at observed shots have labels of their own.
SCHEMA_VERSION = 2
AXES, POINTS = "*", "@"

Kind = Literal["number", "integer", "text", "flag", "mask"]

# States of a run; the cube stores the position. "other" keeps its word in the reason.
STATES = (
    "succeeded",
    "failed",
    "crashed",
    "timed_out",
    "out_of_memory",
    "cancelled",
    "running",
    "pending",
    "missing",
    "other",
)
IN_RANGE = ("outside_range", "inside_range")
VERDICT_WORDS = tuple(verdict.replace(" ", "_") for verdict in VERDICTS)


class SchemaError(WhippleError):
    """A cube holds a variable that is not declared, or not as declared."""


@dataclass(frozen=True)
class Variable:
    """A variable of the cube: its name, what it varies along, its unit and its meaning."""

    name: str
    dims: tuple[str, ...]
    unit: str | None  # UDUNITS; None for text and flags
    meaning: str
    kind: Kind = "number"
    words: tuple[str, ...] = ()  # of a flag: what its values 0, 1, ... mean

    def attributes(self) -> dict[str, str]:
        """What CF wants to see on the variable."""
        units = {"units": self.unit} if self.unit is not None else {}
        return {**units, "long_name": self.meaning}


@dataclass(frozen=True)
class Quantity:
    """Something that is measured on a run, as its measurement describes it."""

    name: str  # "hole_diameter"
    unit: str  # "m"
    meaning: str


@dataclass(frozen=True)
class Vocabulary:
    """The words of one sweep, from which the names of its cube are made."""

    axes: tuple[str, ...]  # dimensions: ("speed", "plate_thickness"), or ("run",) for a zip
    refinements: tuple[str, ...]  # the last of these: "cells_per_diameter", "offset", both or none
    quantities: Mapping[str, Quantity]
    parameters: Mapping[str, Parameter] = field(default_factory=dict)
    parts: Mapping[str, tuple[str, ...]] = field(default_factory=dict)  # of each uncertainty

    @property
    def points(self) -> tuple[str, ...]:
        """The dimensions of the points that a user asked for, before they are refined."""
        return self.axes[: len(self.axes) - len(self.refinements)]


def variable_name(parameter: str) -> str:
    """A parameter's path as a CF name.

    >>> variable_name("target.strength.A")
    'target_strength_A'
    """
    return re.sub(r"\W", "_", parameter)


RUN = (
    Variable("run", ("run",), None, "number of the run", "integer"),
    Variable("run_id", (AXES,), None, "content identity of the run", "text"),
    Variable("run_state", (AXES,), None, "state of the run", "flag", STATES),
    Variable("run_reason", (AXES,), None, "why the run has no result", "text"),
    Variable("run_failure", (AXES,), None, "kind of failure", "text"),
    Variable("run_flags", (AXES,), None, "warnings about the run", "mask"),
    Variable("stop_reason", (AXES,), None, "what ended the simulation", "text"),
    Variable("solver_seconds", (AXES,), "s", "wall time of the run"),
    Variable("solver_threads", (AXES,), "1", "threads that computed the run"),
    Variable(
        "equivalent_diameter",
        (AXES,),
        "m",
        "diameter of the sphere with the projectile's volume, the d of D/d and p/d",
    ),
)

QUANTITY = (
    Variable("{quantity}", (AXES,), "{unit}", "{meaning}"),
    Variable("{quantity}_uncertainty", (AXES,), "{unit}", "uncertainty of {quantity}"),
    Variable("{quantity}_flags", (AXES,), None, "warnings about {quantity}", "mask"),
    Variable("{quantity}_history", (AXES, "sample"), "{unit}", "{quantity} during the run"),
    Variable("{quantity}_history_time", (AXES, "sample"), "s", "time of {quantity}_history"),
)
PART = Variable(
    "{quantity}_uncertainty_{part}",
    (AXES,),
    "{unit}",
    "part of the uncertainty of {quantity}: {part}",
)

CONVERGED = (
    Variable(
        "{quantity}_converged",
        (POINTS,),
        "{unit}",
        "{quantity} over all resolutions and offsets: extrapolated to cells of no size where the "
        "verdict is converging, else the mean of the finest resolution",
    ),
    Variable(
        "{quantity}_converged_uncertainty",
        (POINTS,),
        "{unit}",
        "uncertainty of {quantity}_converged, root of the sum of the squares of its parts",
    ),
    Variable(
        "{quantity}_converged_uncertainty_mesh",
        (POINTS,),
        "{unit}",
        "part of the uncertainty: grid convergence index, or at least the spread of the finest resolutions and what "
        "their noise leaves open",
    ),
    Variable(
        "{quantity}_converged_uncertainty_offsets",
        (POINTS,),
        "{unit}",
        "part of the uncertainty: scatter over sub-cell offsets at the finest resolution",
    ),
    Variable(
        "{quantity}_converged_uncertainty_measurement",
        (POINTS,),
        "{unit}",
        "part of the uncertainty: what the measurement states beside the resolution",
    ),
    Variable(
        "{quantity}_converged_order", (POINTS,), "1", "observed order of convergence of {quantity}"
    ),
    Variable(
        "{quantity}_converged_extrapolated",
        (POINTS,),
        "{unit}",
        "Richardson's value of {quantity} at cells of no size, where converging",
    ),
    Variable(
        "{quantity}_converged_gci",
        (POINTS,),
        "1",
        "grid convergence index of the finest resolution, over its value",
    ),
    Variable(
        "{quantity}_converged_verdict",
        (POINTS,),
        None,
        "what refinement says about {quantity}",
        "flag",
        VERDICT_WORDS,
    ),
    Variable("{quantity}_converged_reason", (POINTS,), None, "why this verdict", "text"),
)

LAW = (
    Variable("{quantity}_law", ("{quantity}_law",), None, "law and variant", "text"),
    Variable(
        "{quantity}_by_law", (POINTS, "{quantity}_law"), "{unit}", "{quantity} by published laws"
    ),
    Variable(
        "{quantity}_by_law_in_range",
        (POINTS, "{quantity}_law"),
        None,
        "whether the law answers inside its stated range",
        "flag",
        IN_RANGE,
    ),
    Variable(
        "{quantity}_by_law_reason",
        (POINTS, "{quantity}_law"),
        None,
        "why the law is outside its range or has no answer",
        "text",
    ),
    Variable("{quantity}_law_name", ("{quantity}_law",), None, "name of the law", "text"),
    Variable(
        "{quantity}_law_variant", ("{quantity}_law",), None, "stated choice of constant", "text"
    ),
    Variable("{quantity}_law_title", ("{quantity}_law",), None, "title of the law", "text"),
    Variable("{quantity}_law_equation", ("{quantity}_law",), None, "equation as published", "text"),
    Variable("{quantity}_law_source", ("{quantity}_law",), None, "source of the law", "text"),
    Variable("{quantity}_law_range", ("{quantity}_law",), None, "range of validity", "text"),
    Variable(
        "{quantity}_law_confidence", ("{quantity}_law",), None, "how sure the form is", "text"
    ),
)

OBSERVATION = (
    Variable("observation", ("observation",), None, "number of the shot", "integer"),
    Variable("observation_source", ("observation",), None, "where the shot is published", "text"),
    Variable(
        "observation_equivalent_diameter",
        ("observation",),
        "m",
        "diameter of the sphere with the projectile's volume",
    ),
)
OBSERVED = (
    Variable("{quantity}_observed", ("observation",), "{unit}", "{meaning}, as observed"),
    Variable(
        "{quantity}_observed_uncertainty",
        ("observation",),
        "{unit}",
        "uncertainty of {quantity}_observed, as stated",
    ),
    Variable(
        "{quantity}_observed_law",
        ("{quantity}_observed_law",),
        None,
        "law and variant, of those stated for an observed shot",
        "text",
    ),
    Variable(
        "{quantity}_observed_law_title",
        ("{quantity}_observed_law",),
        None,
        "title of the law",
        "text",
    ),
    Variable(
        "{quantity}_by_law_at_observation",
        ("observation", "{quantity}_observed_law"),
        "{unit}",
        "{quantity} by published laws for each shot",
    ),
    Variable(
        "{quantity}_by_law_at_observation_in_range",
        ("observation", "{quantity}_observed_law"),
        None,
        "whether the law answers inside its stated range",
        "flag",
        IN_RANGE,
    ),
)


def _number(name: str, unit: str, meaning: str) -> Variable:
    return Variable(f"audit_{name}", (AXES,), unit, meaning)


NUMBERS = (
    _number("cells_per_diameter", "1", "grid cells across the diameter of the projectile or bar"),
    _number(
        "cells_per_thickness", "1", "grid cells through the target, or the flyer where plates meet"
    ),
    _number("particles", "1", "particles of the simulation"),
    _number("steps", "1", "time steps taken"),
    _number("particle_steps", "1", "particles times the steps that each was moved"),
    _number("end_time", "s", "simulated time at the end"),
    _number("smallest_step", "s", "smallest time step"),
    _number("energy_drift", "1", "energy unaccounted for at the end, over the initial energy"),
    _number("largest_energy_drift", "1", "largest energy drift at any time of the run"),
    _number("momentum_error", "1", "momentum unaccounted for, over the initial momentum"),
    _number("mass_error", "1", "mass unaccounted for, over the initial mass"),
    _number("hottest_energy_share", "1", "share of internal energy in the hottest particles"),
    _number(
        "removed_energy_fraction",
        "1",
        "energy taken by walls, absorbing surfaces, contact and damping, over the initial",
    ),
    _number(
        "contact_energy_fraction", "1", "energy taken by contact of bodies alone, over the initial"
    ),
    _number(
        "outflow_mass_fraction", "1", "mass that left the grid or was retired, over the initial"
    ),
    _number(
        "outflow_energy_fraction", "1", "energy that left the grid or was retired, over the initial"
    ),
    _number(
        "separated_mass_fraction", "1", "target not connected to its rim, or gone, over its mass"
    ),
    _number("fast_mass_fraction", "1", "connected target above 300 m/s, over the target's mass"),
    _number("largest_speed", "m s-1", "largest speed of a particle"),
    _number("tension_floors", "1", "uses of the floor that limits tension"),
    _number("beyond_hugoniot", "1", "states compressed beyond the Hugoniot's limit"),
    _number("below_zero_kelvin", "1", "states whose energy gave a negative temperature"),
    _number("below_expansion", "1", "states thinner than the range of the equation of state"),
    _number("molten", "1", "states at or above the melting point"),
    _number("sound_floors", "1", "uses of the floor of the sound speed in the time step"),
    _number("unstable", "1", "states whose pressure falls with density"),
    _number("failed", "1", "particles that failed for good"),
    _number("reflected", "1", "particles turned back at a wall"),
)


def schema(words: Vocabulary) -> dict[str, Variable]:
    """Every variable that a cube with these words may hold, by name."""
    return {variable.name: variable for variable in _declared(words)}


def _declared(words: Vocabulary) -> Iterator[Variable]:
    # A word of the sweep comes first, so that a fixed name always wins over it.
    for parameter in words.parameters.values():
        yield from _of_parameter(parameter, words)
    for quantity in words.quantities.values():
        yield from _of_quantity(quantity, words)
    for variable in (*RUN, *OBSERVATION, *NUMBERS):
        yield _filled(variable, {}, words)


def _of_parameter(parameter: Parameter, words: Vocabulary) -> Iterator[Variable]:
    name = variable_name(parameter.name)
    kind: Kind = "text" if parameter.unit is None else "number"
    dims = (name,) if name in words.axes else words.axes
    yield Variable(name, dims, parameter.unit, parameter.meaning, kind)
    yield Variable(
        f"observation_{name}",
        ("observation",),
        parameter.unit,
        f"{parameter.meaning} of the shot",
        kind,
    )


def _of_quantity(quantity: Quantity, words: Vocabulary) -> Iterator[Variable]:
    filling = {"quantity": quantity.name, "unit": quantity.unit, "meaning": quantity.meaning}
    converged = CONVERGED if words.refinements else ()
    for variable in (*QUANTITY, *converged, *LAW, *OBSERVED):
        yield _filled(variable, filling, words)
    for part in words.parts.get(quantity.name, ()):
        yield _filled(PART, {**filling, "part": part}, words)


def _filled(variable: Variable, filling: Mapping[str, str], words: Vocabulary) -> Variable:
    """The variable with its braces and its dimension ``*`` replaced."""
    return replace(
        variable,
        name=variable.name.format(**filling),
        dims=tuple(_dims(variable.dims, filling, words)),
        unit=variable.unit and variable.unit.format(**filling),
        meaning=variable.meaning.format(**filling),
    )


def _dims(dims: Iterable[str], filling: Mapping[str, str], words: Vocabulary) -> Iterator[str]:
    for dim in dims:
        if dim in (AXES, POINTS):
            yield from words.axes if dim == AXES else words.points
        else:
            yield dim.format(**filling)


def vocabulary_as_json(words: Vocabulary) -> dict[str, Any]:
    """The words as plain objects: an attribute of the cube, so that it can be validated alone."""
    return {
        "axes": list(words.axes),
        "refinements": list(words.refinements),
        "quantities": {q.name: [q.unit, q.meaning] for q in words.quantities.values()},
        "parameters": {p.name: [p.kind, p.unit, p.meaning] for p in words.parameters.values()},
        "parts": {name: list(parts) for name, parts in words.parts.items()},
    }


def vocabulary_from_json(plain: Mapping[str, Any]) -> Vocabulary:
    """The words that :func:`vocabulary_as_json` wrote."""
    return Vocabulary(
        axes=tuple(plain["axes"]),
        refinements=tuple(plain.get("refinements", ())),  # a cube of schema 1 has none
        quantities={
            name: Quantity(name, unit, meaning)
            for name, (unit, meaning) in plain["quantities"].items()
        },
        parameters={
            name: Parameter(name=name, kind=kind, unit=unit, meaning=meaning)
            for name, (kind, unit, meaning) in plain["parameters"].items()
        },
        parts={name: tuple(parts) for name, parts in plain["parts"].items()},
    )
