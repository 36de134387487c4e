"""Variables of the cube: each declared once, with name, dimensions, unit, meaning, and the pick of its value.

A name in braces is filled in for each sweep: ``{quantity}`` for a measured quantity (``hole_diameter``). A variable
lies over ``RUNS``, all dimensions of the runs; over ``POINTS``, the same without the refinements (resolution and
offset, which are dimensions where a sweep names several); or over a dimension of its own. ``pick`` reads one value
from one record: a cell of the cube, a measurement, what refinement says, a law, its answer, a shot.

How to add one: a number of the audit is one line of ``AUDIT``; a quantity comes from its measurement, a parameter from
its scenario, and neither needs an edit here.
"""

import json
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Literal, get_args

import numpy as np
import xarray as xr

from studies.convergence.richardson import VERDICTS
from studies.values.parameters import Parameter
from studies.values.results import ENERGY_DRIFT_LIMIT

# 2: refinements and what converges over them; laws at observed shots have labels of their own.
# 3: groups, short labels with the meaning in ``comment``, parameters as coordinates, one time for all histories.
SCHEMA_VERSION = 3

Kind = Literal["number", "integer", "text", "flag", "mask"]
DTYPES = {"number": float, "integer": np.int32, "text": object, "flag": np.int8, "mask": np.int32}
EMPTY = {"number": np.nan, "integer": 0, "text": "", "flag": 0, "mask": 0}

# Of the variables, in the order of a cube; ``Dataset.filter_by_attrs(group="result")`` selects one.
Group = Literal["parameter", "result", "detail", "history", "run", "audit", "observation"]
GROUPS: tuple[Group, ...] = get_args(Group)
LONGEST_LABEL = 40  # characters of a long_name: longer ones are cut off beside an axis

RUNS, POINTS = ("*",), ("@",)  # stand for the dimensions of the runs and of the points
LAW, OBSERVATION = "{quantity}_law", "observation"
OBSERVED_LAW = "{quantity}_observed_law"

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
RUN_FLAGS = (
    "under_resolved",
    "energy_drift",
    "runaway_particles",
    "below_zero_kelvin",
    "beyond_hugoniot",
)
IN_RANGE = ("outside_range", "inside_range")
VERDICT_WORDS = tuple(verdict.replace(" ", "_") for verdict in VERDICTS)


@dataclass(frozen=True)
class Quantity:
    """Something that is measured on a run, as its measurement describes it."""

    name: str  # "hole_diameter"
    unit: str  # "m"
    meaning: str


@dataclass(frozen=True)
class Variable:
    """A variable of the cube."""

    name: str
    meaning: str
    pick: Callable[[Any], Any]  # the value of one record; None where it has none
    dims: tuple[str, ...]
    unit: str | None = None  # UDUNITS; None for text and flags
    kind: Kind = "number"
    # Meanings of the values 0, 1, ... of a flag, or of the bits of a mask.
    meanings: tuple[str, ...] = ()
    label: str = (
        ""  # a few words for an axis; by default the meaning, or the name where that is long
    )
    group: Group = "detail"

    @property
    def long_name(self) -> str:
        """The label of an axis: at most ``LONGEST_LABEL`` characters."""
        if self.label:
            return self.label
        return self.meaning if len(self.meaning) <= LONGEST_LABEL else self.name.replace("_", " ")

    @property
    def comment(self) -> str:
        """The definition, where the label does not say it; else empty."""
        return "" if self.meaning == self.long_name else self.meaning

    def filled(self, quantity: Quantity) -> "Variable":
        """The variable of one quantity."""
        filling = {
            "quantity": quantity.name,
            "words": quantity.name.replace("_", " "),
            "unit": quantity.unit,
            "meaning": quantity.meaning,
        }
        return replace(
            self,
            name=self.name.format(**filling),
            dims=tuple(dim.format(**filling) for dim in self.dims),
            unit=self.unit and self.unit.format(**filling),
            meaning=self.meaning.format(**filling),
            label=self.label.format(**filling),
        )

    def named(self, quantity: str = "") -> str:
        """The name that it has in a cube."""
        return self.name.format(quantity=quantity)

    def is_in(self, dataset: xr.Dataset, quantity: str = "") -> bool:
        """Whether a cube has it."""
        return self.named(quantity) in dataset

    def of(self, dataset: xr.Dataset, quantity: str = "") -> xr.DataArray:
        """Its values in a cube."""
        return dataset[self.named(quantity)]

    def values(self, records: np.ndarray) -> np.ndarray:
        """One value a record, of an array of records (objects; None has no value)."""
        values = np.full(records.shape, EMPTY[self.kind], DTYPES[self.kind])
        for place, record in np.ndenumerate(records):
            picked = None if record is None else self.pick(record)
            if picked is not None:
                values[place] = self.meanings.index(picked) if self.kind == "flag" else picked
        return values


def variable_name(parameter: str) -> str:
    """A parameter's path as a CF name.

    >>> variable_name("target.strength.A")
    'target_strength_A'
    """
    return re.sub(r"\W", "_", parameter)


def parameter_variable(parameter: Parameter, dims: tuple[str, ...]) -> Variable:
    """The variable of a parameter; its records are the parameter's values."""
    kind: Kind = "text" if parameter.unit is None else "number"
    pick = str if kind == "text" else float
    name = variable_name(parameter.name)
    label = parameter.name.replace("_", " ").replace(".", " ")
    return Variable(
        *(name, parameter.meaning, pick, dims, parameter.unit, kind),
        label=label,
        group="parameter",
    )


def observed_parameter(parameter: Parameter) -> Variable:
    """The variable of a parameter as observed shots state it; its records are the parameter's values."""
    variable = parameter_variable(parameter, (OBSERVATION,))
    meaning = f"{parameter.meaning} of the shot"
    return replace(
        variable,
        name=f"observation_{variable.name}",
        meaning=meaning,
        label=f"{variable.label} (shot)",
        group="observation",
    )


# ---- of a run: a record is a cell ----------------------------------------------------------------

_text_of_run = partial(Variable, dims=RUNS, kind="text", group="run")
_number_of_run = partial(Variable, dims=RUNS, group="run")

RUN_ID = _text_of_run("run_id", "content identity of the run", lambda cell: cell.run.id)
RUN_REASON = _text_of_run("run_reason", "why the run has no result", lambda cell: cell.reason)
RUN_FAILURE = _text_of_run("run_failure", "kind of failure", lambda cell: cell.of_result("failure"))
STOP_REASON = _text_of_run(
    "stop_reason", "reason for the end of the simulation", lambda cell: cell.of_result("stop")
)
RUN_STATE = Variable(
    *("run_state", "state of the run", lambda cell: cell.state, RUNS),
    kind="flag",
    meanings=STATES,
    group="run",
)
FLAGS_OF_RUN = Variable(
    "run_flags",
    "warnings about the run",
    lambda cell: cell.of_result("flags"),
    RUNS,
    kind="mask",
    meanings=RUN_FLAGS,
    group="run",
)
SOLVER_SECONDS = _number_of_run(
    "solver_seconds", "wall time of the run", lambda cell: cell.provenance.get("seconds"), unit="s"
)
SOLVER_THREADS = _number_of_run(
    "solver_threads",
    "threads that computed the run",
    lambda cell: cell.provenance.get("threads"),
    unit="1",
)
OF_RUN = (
    RUN_ID,
    RUN_STATE,
    RUN_REASON,
    RUN_FAILURE,
    FLAGS_OF_RUN,
    STOP_REASON,
    SOLVER_SECONDS,
    SOLVER_THREADS,
)
RUN_NUMBER = Variable("run", "number of the run", int, ("run",), kind="integer")
EQUIVALENT_DIAMETER = _number_of_run(
    "equivalent_diameter",
    "diameter of the sphere with the projectile's volume, the d of D/d and p/d",
    lambda cell: getattr(cell.shot, "projectile_diameter", None),
    unit="m",
    label="equivalent diameter of the projectile",
)


# ---- of a run: its audit -------------------------------------------------------------------------


@dataclass(frozen=True)
class AuditNumber:
    """A number that a run states about its own quality."""

    name: str  # as in the result of the run
    unit: str
    meaning: str
    share: bool = False  # people read it in per cent
    limit: float | None = None  # beyond it, on either side of zero, a run is marked
    shown: bool = True  # in the report

    @property
    def variable(self) -> Variable:
        """Its variable of the cube; a record is a cell."""
        return _number_of_run(
            f"audit_{self.name}",
            self.meaning,
            lambda cell: cell.numbers.get(self.name),
            unit=self.unit,
            label=self.name.replace("_", " "),
            group="audit",
        )


_share = partial(AuditNumber, unit="1", share=True)
_drift = partial(_share, limit=ENERGY_DRIFT_LIMIT)

AUDIT = (
    AuditNumber(
        "cells_per_diameter", "1", "grid cells across the diameter of the projectile or bar"
    ),
    AuditNumber(
        "cells_per_thickness", "1", "grid cells through the target, or the flyer where plates meet"
    ),
    AuditNumber("particles", "1", "particles of the simulation"),
    AuditNumber("steps", "1", "time steps taken"),
    AuditNumber("particle_steps", "1", "particles times the steps that each was moved"),
    AuditNumber("end_time", "s", "simulated time at the end"),
    AuditNumber("smallest_step", "s", "smallest time step"),
    _drift(
        "energy_drift",
        meaning="energy unaccounted for at the end, over the initial energy and the loads' work",
    ),
    _drift("largest_energy_drift", meaning="largest energy drift at any time of the run"),
    _share("momentum_error", meaning="momentum unaccounted for, over the initial momentum"),
    _share("mass_error", meaning="mass unaccounted for, over the initial mass"),
    _share("hottest_energy_share", meaning="share of internal energy in the hottest particles"),
    _share(
        "removed_energy_fraction",
        meaning="energy removed by walls, absorbing surfaces, contact, damping, over the initial and the loads' work",
    ),
    _share(
        "contact_energy_fraction",
        meaning="energy removed by contact of bodies alone, over the initial and the loads' work",
    ),
    _share(
        "outflow_mass_fraction", meaning="mass that left the grid or was retired, over the initial"
    ),
    _share(
        "outflow_energy_fraction",
        meaning="energy that left the grid or was retired, over the initial and the loads' work",
    ),
    # Zero in every scenario but those of bars.
    AuditNumber(
        "load_work",
        "J",
        "work of pressures and gravity up to the end, on whole bodies",
        shown=False,
    ),
    _share(
        "separated_mass_fraction", meaning="target not connected to its rim, or gone, over its mass"
    ),
    _share("fast_mass_fraction", meaning="connected target above 300 m/s, over the target's mass"),
    _share(
        "molten_mass_fraction",
        meaning="matter at or above its melting point at the end, over the initial mass",
    ),
    AuditNumber("largest_speed", "m s-1", "largest speed of a particle"),
    AuditNumber("tension_floors", "1", "uses of the floor that limits tension"),
    AuditNumber("beyond_hugoniot", "1", "states compressed beyond the Hugoniot's limit"),
    AuditNumber("below_zero_kelvin", "1", "states whose energy gave a negative temperature"),
    AuditNumber("below_expansion", "1", "states thinner than the range of the equation of state"),
    # A state is a particle in a step: what people ask for is the molten mass.
    AuditNumber("molten", "1", "states at or above the melting point", shown=False),
    AuditNumber("sound_floors", "1", "uses of the floor of the sound speed in the time step"),
    AuditNumber("unstable", "1", "states whose pressure falls with density"),
    AuditNumber("failed", "1", "particles that failed for good"),
    AuditNumber("reflected", "1", "particles turned back at a wall"),
)


# ---- of a run: its histories; a record is a cell, or a cell and a body --------------------------


@dataclass(frozen=True)
class RunHistory:
    """A number of a run over time: of each body, or of all."""

    name: str  # as in the histories of a result
    unit: str
    meaning: str
    by_body: bool = True

    @property
    def variable(self) -> Variable:
        """Its variable of the cube; a record is the values of a run, or those of a body in it."""
        return Variable(
            # Quantities have histories too: those of bodies are told apart.
            f"{'body_' if self.by_body else ''}{self.name}_history",
            f"{self.meaning}, over history_time",
            lambda values: values,
            (*RUNS, BODY, "sample") if self.by_body else (*RUNS, "sample"),
            self.unit,
            label=f"{self.name.replace('_', ' ')}, history",
            group="history",
        )


BODY = "body"
BODY_NAME = Variable(BODY, "body of the problem", str, (BODY,), kind="text")

# The sum of the energies over kinds and bodies, less the work of loads, is the initial energy and what the audit calls
# drift; that of the momenta, less the impulse, is the initial momentum. Models of a sector count for the whole.
HISTORIES = (
    RunHistory("kinetic_energy", "J", "kinetic energy of the particles of a body on the grid"),
    RunHistory("internal_energy", "J", "internal energy of the particles of a body on the grid"),
    RunHistory(
        "departed_energy", "J", "energy of the particles that left the grid or were retired"
    ),
    RunHistory("axial_momentum", "N s", "momentum along the line of flight, on the grid"),
    RunHistory(
        "departed_axial_momentum",
        "N s",
        "momentum along the line of flight of the particles that left the grid or were retired",
    ),
    RunHistory("contact_energy", "J", "energy that contact of the bodies removed", by_body=False),
    RunHistory(
        "otherwise_removed_energy",
        "J",
        "energy that damping, walls and absorbing surfaces removed",
        by_body=False,
    ),
    RunHistory("load_work", "J", "work of pressures and gravity", by_body=False),
    RunHistory(
        "axial_impulse",
        "N s",
        "impulse that faces, absorbing surfaces and loads gave along the line of flight",
        by_body=False,
    ),
)


# ---- of a run: its distributions; a record is an array --------------------------------------------


def bins_variable(bins: Any) -> Variable:
    """The coordinate of some bins (``studies.measurements._distributions``); a record is the middle of one."""
    meaning = f"{bins.meaning}; middles of bins {bins.width:.6g} wide"
    return Variable(bins.name, meaning, float, (bins.name,), bins.unit, label=bins.title)


def distribution_variable(distribution: Any) -> Variable:
    """The variable of a distribution."""
    return Variable(
        distribution.name,
        distribution.meaning,
        lambda values: values,
        (*RUNS, *(bins.name for bins in distribution.bins)),
        distribution.unit,
        label=distribution.title.lower(),
        group="result",
    )


# ---- of a quantity: a record is a measurement ----------------------------------------------------

_measured = partial(Variable, dims=RUNS, unit="{unit}")

VALUE = _measured(
    "{quantity}", "{meaning}", lambda measured: measured.value, label="{words}", group="result"
)
UNCERTAINTY = _measured(
    "{quantity}_uncertainty",
    "uncertainty of {quantity}",
    lambda measured: measured.uncertainty,
    label="{words}, uncertainty",
    group="result",
)
FLAGS = Variable(
    *("{quantity}_flags", "warnings about {quantity}", lambda each: each.flags, RUNS),
    kind="mask",
    label="{words}, warnings",
)
HISTORY = Variable(
    "{quantity}_history",
    "{quantity} during the run, over history_time",
    lambda measured: measured.history.get("value", ()),
    (*RUNS, "sample"),
    "{unit}",
    label="{words}, history",
    group="history",
)
# A record is the times (s) of a run.
HISTORY_TIME = Variable(
    "history_time",
    "simulated time of the samples of a run's histories",
    lambda times: times,
    (*RUNS, "sample"),
    "s",
    label="time",
    group="history",
)


def uncertainty_part(part: str) -> Variable:
    """The variable of one part of an uncertainty: growth, azimuth, resolution."""
    return _measured(
        f"{{quantity}}_uncertainty_{part}",
        f"part of the uncertainty of {{quantity}}: {part}",
        lambda measured: measured.parts.get(part),
        label=f"{{words}}, {part}",
    )


# ---- of a quantity in a run: a record is what its models leave open (studies.cubes.models) --------

MODEL_PART = _measured(
    "{quantity}_model_part",
    "standard uncertainty of {quantity} due to strength, failure and equation of state; NaN: not assessed",
    lambda assessed: assessed.uncertainty,
    label="{words}, model part",
)
MODEL_REASON = Variable(
    "{quantity}_model_part_reason",
    "contributions to {quantity}_model_part and their source, or why it is not assessed",
    lambda assessed: assessed.reason,
    RUNS,
    kind="text",
    label="{words}, model text",
)


def model_contribution(contribution: str) -> Variable:
    """The variable of one contribution to the model part: strength, failure, equation of state."""
    return Variable(
        f"{{quantity}}_model_part_{contribution.replace(' ', '_')}",
        f"relative standard uncertainty of {{quantity}} due to {contribution}; NaN: not assessed",
        lambda assessed: assessed.shares.get(contribution),
        RUNS,
        "1",
        label=f"{{words}}, {contribution}",
    )


# Over the points: it converges with nothing. A record is the number itself (``cells.definition_part``).
DEFINITION_PART = Variable(
    "{quantity}_definition_part",
    "uncertainty of {quantity} by its definition, no numerical part: half of its difference from a second definition",
    lambda part: part,
    POINTS,
    "{unit}",
    label="{words}, definition",
)


# ---- of a quantity at a point: a record is its convergence ---------------------------------------

_converged = partial(Variable, dims=POINTS, unit="{unit}")
_pure = partial(Variable, dims=POINTS, unit="1")

CONVERGED = _converged(
    "{quantity}_converged",
    "{quantity} over all resolutions and offsets: extrapolated to cells of no size where it "
    "converges and that is more certain, else the mean of the finest resolution",
    lambda point: point.value,
    label="{words}, converged",
    group="result",
)
CONVERGED_UNCERTAINTY = _converged(
    "{quantity}_converged_uncertainty",
    "uncertainty of {quantity}_converged, root of the sum of the squares of its parts",
    lambda point: point.uncertainty,
    label="{words}, error bar",
    group="result",
)
MESH_PART = _converged(
    "{quantity}_converged_uncertainty_mesh",
    "part of the uncertainty: error left by the mesh, and what the scatter over offsets makes of the value",
    lambda point: point.mesh,
    label="{words}, mesh part",
)
OFFSETS_PART = _converged(
    "{quantity}_converged_uncertainty_offsets",
    "part of the uncertainty: scatter of the mean over sub-cell offsets at the finest resolution",
    lambda point: point.offsets,
    label="{words}, offset part",
)
MEASUREMENT_PART = _converged(
    "{quantity}_converged_uncertainty_measurement",
    "part of the uncertainty: parts that the measurement states besides the resolution",
    lambda point: point.measurement,
    label="{words}, reading",
)
ORDER = _pure(
    "{quantity}_converged_order",
    "observed order of convergence of {quantity}",
    lambda each: each.order,
    label="{words}, order",
)
EXTRAPOLATED = _converged(
    "{quantity}_converged_extrapolated",
    "Richardson's value of {quantity} at cells of no size, where converging",
    lambda point: point.extrapolated,
    label="{words}, Richardson",
)
GCI = _pure(
    "{quantity}_converged_gci",
    "grid convergence index of the finest resolution, over its value",
    lambda point: point.gci,
    label="{words}, GCI",
)
VERDICT = Variable(
    "{quantity}_converged_verdict",
    "convergence verdict of {quantity}",
    lambda point: VERDICT_WORDS[VERDICTS.index(point.verdict)],
    POINTS,
    kind="flag",
    meanings=VERDICT_WORDS,
    label="{words}, verdict",
)
VERDICT_REASON = Variable(
    "{quantity}_converged_reason",
    "why this verdict",
    lambda each: each.reason,
    POINTS,
    kind="text",
    label="{words}, reason",
)
NUMBERS_OF_CONVERGENCE = (
    CONVERGED,
    CONVERGED_UNCERTAINTY,
    MESH_PART,
    OFFSETS_PART,
    MEASUREMENT_PART,
    ORDER,
    EXTRAPOLATED,
    GCI,
)
OF_CONVERGENCE = (*NUMBERS_OF_CONVERGENCE, VERDICT, VERDICT_REASON)


# ---- of a law: a record is a law with one of its variants, or its answer -------------------------

_text_of_law = partial(Variable, dims=(LAW,), kind="text")
_in_range = partial(
    Variable,
    meaning="whether the shot lies inside the stated range of the law",
    pick=lambda answer: IN_RANGE[answer.in_range],
    kind="flag",
    meanings=IN_RANGE,
)

EQUATION = (
    "equation: "  # before the word of confidence: it is not about the constants of a material
)

LAW_LABEL = _text_of_law(LAW, "law and variant", lambda choice: choice.label)
BY_LAW = Variable(
    "{quantity}_by_law",
    "{quantity} by published laws",
    lambda answer: answer.value,
    (*POINTS, LAW),
    "{unit}",
    label="{words} by laws",
    group="result",
)
BY_LAW_IN_RANGE = _in_range(
    "{quantity}_by_law_in_range", dims=(*POINTS, LAW), label="{words}, in range"
)
BY_LAW_REASON = Variable(
    "{quantity}_by_law_reason",
    "why the law is outside its range or has no answer",
    lambda answer: answer.reason,
    (*POINTS, LAW),
    kind="text",
    label="{words}, law reason",
)
LAW_VARIANT = _text_of_law(
    "{quantity}_law_variant", "stated choice of constant", lambda choice: choice.variant
)
LAW_NAME = _text_of_law("{quantity}_law_name", "name of the law", lambda each: each.law.name)
LAW_TITLE = _text_of_law("{quantity}_law_title", "title of the law", lambda each: each.law.title)
LAW_EQUATION = _text_of_law(
    "{quantity}_law_equation", "equation as published", lambda choice: choice.law.equation
)
LAW_SOURCE = _text_of_law(
    "{quantity}_law_source", "source of the law", lambda each: each.law.source
)
LAW_RANGE = _text_of_law(
    "{quantity}_law_range", "range of validity", lambda choice: choice.law.range.words
)
LAW_CONFIDENCE = _text_of_law(
    "{quantity}_law_confidence",
    "confidence in the equation",
    lambda each: EQUATION + each.law.confidence,
)
LAW_SCATTER = Variable(
    "{quantity}_law_scatter",
    "published scatter of measured values about the law, relative standard deviation; NaN: not published",
    lambda each: each.law.scatter,
    (LAW,),
    "1",
    label="relative scatter about the law",
)
OF_ANSWERS = (BY_LAW, BY_LAW_IN_RANGE, BY_LAW_REASON)
OF_LAWS = (
    LAW_VARIANT,
    LAW_NAME,
    LAW_TITLE,
    LAW_EQUATION,
    LAW_SOURCE,
    LAW_RANGE,
    LAW_CONFIDENCE,
    LAW_SCATTER,
)


# ---- of observed shots: a record is a shot, a law, or its answer ---------------------------------

_of_shot = partial(Variable, dims=(OBSERVATION,), group="observation")

OBSERVATION_NUMBER = _of_shot(OBSERVATION, "number of the shot", int, kind="integer")
OBSERVATION_SOURCE = _of_shot(
    "observation_source", "where the shot is published", lambda shot: shot.source, kind="text"
)
OBSERVATION_CONFIDENCE = _of_shot(
    "observation_confidence",
    "how well the shot's numbers are known to be the source's",
    lambda shot: shot.confidence,
    kind="text",
)
OBSERVATION_DIAMETER = _of_shot(
    "observation_equivalent_diameter",
    "diameter of the sphere with the projectile's volume",
    lambda shot: getattr(shot.shot, "projectile_diameter", None),
    unit="m",
)
OBSERVED = _of_shot(
    "{quantity}_observed",
    "{meaning}, as observed",
    lambda shot: shot.value,
    unit="{unit}",
    label="{words}, observed",
    group="observation",
)
OBSERVED_UNCERTAINTY = _of_shot(
    "{quantity}_observed_uncertainty",
    "uncertainty of {quantity}_observed, as stated",
    lambda shot: shot.uncertainty,
    unit="{unit}",
    label="{words}, shot error",
    group="observation",
)
OBSERVED_LAW_LABEL = Variable(
    OBSERVED_LAW,
    "law and variant, of those stated for an observed shot",
    lambda choice: choice.label,
    (OBSERVED_LAW,),
    kind="text",
    label="law and variant of a shot",
    group="observation",
)
OBSERVED_LAW_TITLE = Variable(
    "{quantity}_observed_law_title",
    "title of the law",
    lambda choice: choice.law.title,
    (OBSERVED_LAW,),
    kind="text",
    label="title of the law",
    group="observation",
)
OBSERVED_LAW_CONFIDENCE = Variable(
    "{quantity}_observed_law_confidence",
    "confidence in the equation",
    lambda choice: EQUATION + choice.law.confidence,
    (OBSERVED_LAW,),
    kind="text",
    group="observation",
)
BY_LAW_AT_OBSERVATION = Variable(
    "{quantity}_by_law_at_observation",
    "{quantity} by published laws for each shot",
    lambda answer: answer.value,
    (OBSERVATION, OBSERVED_LAW),
    "{unit}",
    label="{words}, law at shot",
    group="observation",
)
BY_LAW_AT_OBSERVATION_IN_RANGE = _in_range(
    "{quantity}_by_law_at_observation_in_range",
    dims=(OBSERVATION, OBSERVED_LAW),
    label="{words}, in range",
    group="observation",
)
BY_LAW_AT_OBSERVATION_REASON = Variable(
    "{quantity}_by_law_at_observation_reason",
    "why the law is outside its range, or has no answer, for each shot",
    lambda answer: answer.reason,
    (OBSERVATION, OBSERVED_LAW),
    kind="text",
    label="{words}, shot reason",
)
OF_OBSERVED_LAWS = (OBSERVED_LAW_LABEL, OBSERVED_LAW_TITLE, OBSERVED_LAW_CONFIDENCE)
OF_ANSWERS_AT_OBSERVATIONS = (
    BY_LAW_AT_OBSERVATION,
    BY_LAW_AT_OBSERVATION_IN_RANGE,
    BY_LAW_AT_OBSERVATION_REASON,
)


# ---- what readers of a cube share ----------------------------------------------------------------


def quantities_of(dataset: xr.Dataset) -> list[str]:
    """Names of the measured quantities of a cube."""
    return str(dataset.attrs["quantities"]).split()


def confidences_of(
    dataset: xr.Dataset, quantity: str, variable: Variable = LAW_CONFIDENCE
) -> list[str]:
    """The word of confidence of each law of a quantity, in the order of the labels; empty of cubes that lack it."""
    if not variable.is_in(dataset, quantity):
        return []
    return [str(text).removeprefix(EQUATION) for text in variable.of(dataset, quantity).values]


def mixed_versions(dataset: xr.Dataset, quantity: str) -> list[int]:
    """Versions of the definition of a quantity, where the runs of a cube were measured with several; else none."""
    versions: list[int] = json.loads(dataset.attrs["measurement_versions"]).get(quantity, [])
    return versions if len(versions) > 1 else []


def meaning_of(array: xr.DataArray) -> str:
    """The definition of a variable of a cube."""
    return str(array.attrs.get("comment") or array.attrs["long_name"])


def flag_meanings(flags: xr.DataArray) -> list[tuple[int, str]]:
    """Bit and meaning of each flag of a mask."""
    masks: Sequence[int] = np.atleast_1d(flags.attrs["flag_masks"]).tolist()
    return list(zip(masks, str(flags.attrs["flag_meanings"]).split(), strict=True))


def flag_words(flags: xr.DataArray) -> list[tuple[str, ...]]:
    """The flags of each cell in words, in the order of ``values.ravel()``."""
    meanings = flag_meanings(flags)
    return [
        tuple(word for mask, word in meanings if value & mask) for value in flags.values.ravel()
    ]


def by_run(dataset: xr.Dataset, array: xr.DataArray) -> np.ndarray:
    """The values of a variable for each run, in the shape of ``run_state``, whatever it varies along.

    Without xarray's alignment, which takes milliseconds: the variables of a cube share their coordinates.
    """
    return array.variable.set_dims(dict(dataset.run_state.sizes)).values
