"""Variables of the cube: each declared once, with name, dimensions, unit, meaning, and the pick of its value.

A name in braces is filled in for each sweep: ``{quantity}`` for a measured quantity (``hole_diameter``). A variable
lies over ``RUNS``, all dimensions of the runs; over ``POINTS``, the same without the refinements (resolution and
offset, which are dimensions where a sweep names several); or over a dimension of its own. ``pick`` reads one value
from one record: a cell of the cube, a measurement, what refinement says, a law, its answer, a shot.

How to add one: a number of the audit is one line of ``AUDIT`` in ``audit.py``; a quantity comes from its measurement, a
parameter from its scenario, and neither needs an edit here.
"""

from dataclasses import replace
from functools import partial
from operator import attrgetter

from studies.convergence.richardson import VERDICTS
from studies.cubes.variable import POINTS, ROOT, RUNS, Variable, VariableKind, variable_name
from studies.laws import SPEED, THICKNESS_RATIO, RangeStatus, in_words, range_in_words
from studies.measurements.distributions import Bins, Distribution
from studies.quantities.measured import COMMON_FLAGS, MESH
from studies.quantities.parameters import Parameter

SCHEMA_VERSION = 1

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
    "vaporised",
    "lost_particles",
    "discarded_particles",
    "still_expanding",
)
IN_RANGE = ("outside_range", "inside_range")
HAS_RANGE = ("not_stated", "stated")
VERDICT_WORDS = tuple(verdict.replace(" ", "_") for verdict in VERDICTS)


def parameter_variable(parameter: Parameter, dims: tuple[str, ...]) -> Variable:
    """The variable of a parameter; its records are the parameter's values."""
    kind: VariableKind = "text" if parameter.unit is None else "number"
    pick = str if kind == "text" else float
    name = variable_name(parameter.name)
    label = parameter.name.replace("_", " ").replace(".", " ")
    return Variable(*(name, parameter.meaning, pick, dims, parameter.unit, kind), label=label, group="inputs")


def observed_parameter(parameter: Parameter) -> Variable:
    """The variable of a parameter as observed shots state it; its records are the parameter's values."""
    variable = parameter_variable(parameter, (OBSERVATION,))
    meaning = f"{parameter.meaning} of the shot"
    return replace(
        variable,
        name=f"observation_{variable.name}",
        meaning=meaning,
        label=f"{variable.label} (shot)",
        group="observations",
    )


# ---- of a run: a record is a cell ----------------------------------------------------------------

_text_of_run = partial(Variable, dims=RUNS, kind="text", group="runs")
_number_of_run = partial(Variable, dims=RUNS, group="runs")

RUN_ID = _text_of_run("run_id", "content identity of the run", lambda cell: cell.result.run_id or cell.id)
RUN_REASON = _text_of_run("run_reason", "why the run has no result, or no answer", lambda cell: cell.reason)
RUN_FAILURE = _text_of_run("run_failure", "kind of failure", lambda cell: cell.result.failure)
STOP_REASON = _text_of_run("stop_reason", "reason for the end of the simulation", lambda cell: cell.result.stop)
RUN_STATE = Variable(
    *("run_state", "state of the run", lambda cell: cell.state, RUNS), kind="flag", meanings=STATES, group=ROOT
)
FLAGS_OF_RUN = Variable(
    "run_flags",
    "warnings about the run",
    lambda cell: cell.result.flags,
    RUNS,
    kind="mask",
    meanings=RUN_FLAGS,
    group=ROOT,
)
OF_RUN = (RUN_ID, RUN_STATE, RUN_REASON, RUN_FAILURE, FLAGS_OF_RUN, STOP_REASON)
# Of its computation, for the report and the table of runs (``cube.with_computation``); a record is its provenance.
SOLVER_SECONDS = _number_of_run(
    "solver_seconds", "wall time of the run", lambda made_by: made_by.get("seconds"), unit="s"
)
SOLVER_THREADS = _number_of_run(
    "solver_threads", "threads that computed the run", lambda made_by: made_by.get("threads"), unit="1"
)
RUN_NUMBER = Variable("run", "number of the run", int, ("run",), kind="integer", group=ROOT)
EQUIVALENT_DIAMETER = _number_of_run(
    "equivalent_diameter",
    "diameter of the sphere with the projectile's volume, the d of D/d and p/d",
    lambda cell: getattr(cell.shot, "projectile_diameter", None),
    unit="m",
    label="equivalent diameter of the projectile",
    group=ROOT,
)


# ---- of a run: its distributions; a record is an array --------------------------------------------


def bins_variable(bins: Bins) -> Variable:
    """The coordinate of some bins; a record is the middle of one."""
    meaning = f"{bins.meaning}; middles of bins {bins.width:.6g} wide"
    return Variable(bins.name, meaning, float, (bins.name,), bins.unit, label=bins.title)


def distribution_variable(distribution: Distribution) -> Variable:
    """The variable of a distribution."""
    return Variable(
        distribution.name,
        distribution.meaning,
        lambda values: values,
        (*RUNS, *(bins.name for bins in distribution.bins)),
        distribution.unit,
        label=distribution.title.lower(),
    )


# ---- of a quantity: a record is a measurement ----------------------------------------------------

_measured = partial(Variable, dims=RUNS, unit="{unit}")
_words = partial(Variable, dims=RUNS, kind="text")

VALUE = _measured("{quantity}", "{meaning}", lambda measured: measured.value, label="{words}", group=ROOT)
# As read off the grid of its run, where the expected mesh error is taken off the value.
RAW = _measured(
    "{quantity}_raw",
    "{quantity} as read off the grid of its run; {quantity} itself is without its expected mesh error",
    lambda measured: measured.value,
    label="{words}, raw reading",
)
UNCERTAINTY = _measured(
    "{quantity}_reading_uncertainty",
    "uncertainty of {quantity} in its run: of reading it off the grid, and of the mesh where "
    "{quantity}_uncertainty_mesh states it, which makes it an error bar",
    lambda measured: measured.uncertainty,
    label="{words}, uncertainty",
)
FLAGS = Variable(
    *("{quantity}_flags", "warnings about {quantity}", lambda measured: measured.flags, RUNS),
    kind="mask",
    meanings=COMMON_FLAGS,
    label="{words}, warnings",
    group=ROOT,
)
HISTORY = Variable(
    "{quantity}_history",
    "{quantity} during the run, over history_time",
    lambda measured: measured.history.get("value", ()),
    (*RUNS, "sample"),
    "{unit}",
    label="{words}, history",
)
# A record is the times (s) of a run.
HISTORY_TIME = Variable(
    "history_time",
    "simulated time of the samples of a run's histories",
    lambda times: times,
    (*RUNS, "sample"),
    "s",
    label="time",
)


# Of a point: a record is its measurement, or that of its only run.
ERROR_BAR = Variable(
    "{quantity}_uncertainty",
    "error bar of {quantity}, root of the sum of the squares of its parts; NaN where the error of the mesh is unknown",
    lambda measured: measured.uncertainty if MESH in measured.parts else None,
    POINTS,
    "{unit}",
    label="{words}, error bar",
    group=ROOT,
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
    "standard uncertainty of {quantity} due to strength and equation of state; NaN: not assessed",
    lambda assessed: assessed.uncertainty,
    label="{words}, model part",
    group=ROOT,
)
MODEL_REASON = _words(
    "{quantity}_model_part_reason",
    "contributions to {quantity}_model_part and their source, or why it is not assessed",
    lambda assessed: assessed.reason,
    label="{words}, model text",
)


def _of_side(side: str) -> tuple[Variable, Variable]:
    """How far failures that count move a quantity to one side, and the failure that does."""
    size = _measured(
        f"{{quantity}}_model_part_{side}",
        f"how far another failure than that of the run that docs/failure.md does not throw out makes {{quantity}} "
        f"{'smaller' if side == 'lower' else 'larger'}; NaN: not assessed",
        lambda assessed: (part := getattr(assessed, side)) and part.size,
        label=f"{{words}}, {side} by failure",
    )
    failure = _words(
        f"{{quantity}}_model_part_{side}_failure",
        f"failure that makes {{quantity}}_model_part_{side}; empty where none does",
        lambda assessed: (part := getattr(assessed, side)) and part.failure,
        label=f"{{words}}, {side} failure",
    )
    return size, failure


MODEL_SIDES = (_of_side("lower"), _of_side("upper"))
BETWEEN_FAILURES = ", "
MODEL_THROWN_OUT = _words(
    "{quantity}_model_part_thrown_out",
    "failures that docs/failure.md throws out: {quantity} with them is known and in no part",
    lambda assessed: BETWEEN_FAILURES.join(assessed.thrown_out),
    label="{words}, failures out",
)


MODEL_DISTANCE = Variable(
    "{quantity}_model_part_distance",
    "largest factor by which speed or t/d lie outside of those at which {quantity}_model_part was measured; 1: inside",
    lambda assessed: assessed.distance,
    RUNS,
    "1",
    label="{words}, model away",
)


MODEL_ALLOY = _words(
    "{quantity}_model_part_alloy",
    "alloy for which {quantity}_model_part was computed, where it is not that of the target",
    lambda assessed: assessed.alloy,
    label="{words}, model alloy",
)


def model_contribution(contribution: str) -> Variable:
    """The variable of one contribution to the model part: strength, equation of state."""
    return Variable(
        f"{{quantity}}_model_part_{contribution.replace(' ', '_')}",
        f"relative standard uncertainty of {{quantity}} due to {contribution}; NaN: not assessed",
        lambda assessed: assessed.shares.get(contribution),
        RUNS,
        "1",
        label=f"{{words}}, {contribution.replace('equation of state', 'EOS')}",
    )


# Over the points: it converges with nothing. A record is the number itself (``cells.definition_parts``).
DEFINITION_PART = Variable(
    "{quantity}_definition_part",
    "uncertainty of {quantity} by its definition, no numerical part: half of its difference from a second definition",
    lambda part: part,
    POINTS,
    "{unit}",
    label="{words}, definition",
)


# ---- of a quantity at a point: a record is its convergence ---------------------------------------


def _converged(of: str, name: str, meaning: str, label: str, unit: str = "{unit}") -> Variable:
    """The variable of a number of a convergence, which has it as its attribute ``of``."""
    name, label = f"{{quantity}}_converged{name}", f"{{words}}, {label}"
    return Variable(name, meaning, attrgetter(of), POINTS, unit, label=label, group="refinement")


CONVERGED = _converged(
    "value",
    "",
    "{quantity} over all resolutions and offsets: the mean over offsets at the finest resolution that has a value",
    "converged",
)
CONVERGED_UNCERTAINTY = _converged(
    "uncertainty",
    "_uncertainty",
    "uncertainty of {quantity}_converged, root of the sum of the squares of its known parts: an error bar where the "
    "mesh part is among them",
    "error bar",
)
MESH_PART = _converged(
    "mesh",
    "_uncertainty_mesh",
    "part of the uncertainty: error of the mesh; NaN where the grids show no order",
    "mesh part",
)
_of_verdict = partial(Variable, dims=POINTS, group="refinement")
VERDICT = _of_verdict(
    "{quantity}_converged_verdict",
    "convergence verdict of {quantity}",
    lambda point: VERDICT_WORDS[VERDICTS.index(point.verdict)],
    kind="flag",
    meanings=VERDICT_WORDS,
    label="{words}, verdict",
)
VERDICT_REASON = _of_verdict(
    "{quantity}_converged_reason", "why this verdict", lambda point: point.reason, kind="text", label="{words}, reason"
)
OF_CONVERGENCE = (
    *(CONVERGED, CONVERGED_UNCERTAINTY, MESH_PART),
    _converged(
        "offsets",
        "_uncertainty_offsets",
        "part of the uncertainty: scatter of the mean over sub-cell offsets at the finest resolution",
        "offset part",
    ),
    _converged(
        "measurement",
        "_uncertainty_measurement",
        "part of the uncertainty: parts that the measurement states besides the resolution",
        "reading",
    ),
    _converged("order", "_order", "observed order of convergence of {quantity}, where converging", "order", "1"),
    _converged(
        "extrapolated",
        "_extrapolated",
        "Richardson's value of {quantity} at cells of no size, where converging",
        "Richardson",
    ),
    _converged("gci", "_gci", "grid convergence index of the finest resolution, over its value", "GCI", "1"),
    VERDICT,
    VERDICT_REASON,
)


# ---- of a length over the diameter of the projectile: a record is the ratio ----------------------

OVER_DIAMETER = Variable(
    "{quantity}_over_projectile_diameter",
    "{quantity} over equivalent_diameter, {symbol}",
    lambda ratio: ratio,
    RUNS,
    "1",
    label="{symbol}",
)


# ---- of a law: a record is a law with one of its variants, or its answer -------------------------

_of_law = partial(Variable, dims=(LAW,), group="laws")
_text_of_law = partial(_of_law, kind="text")
_answer = partial(Variable, dims=(*POINTS, LAW), group="laws")
EQUATION = "equation: "  # before the word of confidence: it is not about the constants of a material

LAW_LABEL = _text_of_law(LAW, "law and variant", lambda choice: choice.label)
BY_LAW = _answer(
    "{quantity}_by_law",
    "{quantity} by published laws",
    lambda answer: answer.value,
    unit="{unit}",
    label="{words} by laws",
)
BY_LAW_IN_RANGE = _answer(
    "{quantity}_by_law_in_range",
    "whether the shot lies inside the stated range of the law",
    lambda answer: IN_RANGE[answer.in_range],
    kind="flag",
    meanings=IN_RANGE,
    label="{words}, in range",
)
BY_LAW_STATUS = _answer(
    "{quantity}_by_law_range_status",
    "how the answer stands to the range of the law",
    lambda answer: answer.status,
    kind="flag",
    meanings=tuple(RangeStatus),
    label="{words}, range status",
)
BY_LAW_REASON = _answer(
    "{quantity}_by_law_reason",
    "why the law is outside its range or has no answer",
    lambda answer: in_words(answer.reasons),
    kind="text",
    label="{words}, law reason",
)
LAW_VARIANT = _text_of_law("{quantity}_law_variant", "stated choice of constant", lambda choice: choice.variant)
LAW_NAME = _text_of_law("{quantity}_law_name", "name of the law", lambda choice: choice.law.name)
LAW_TITLE = _text_of_law("{quantity}_law_title", "title of the law", lambda choice: choice.law.title)
LAW_EQUATION = _text_of_law("{quantity}_law_equation", "equation as published", lambda choice: choice.law.equation)
LAW_SOURCE = _text_of_law("{quantity}_law_source", "source of the law", lambda choice: choice.law.source)
LAW_RANGE = _text_of_law("{quantity}_law_range", "range of validity", lambda choice: range_in_words(choice.law.range))
LAW_HAS_RANGE = _of_law(
    "{quantity}_law_has_range",
    "whether the source of the law states a range",
    lambda choice: HAS_RANGE[choice.law.range.is_published],
    kind="flag",
    meanings=HAS_RANGE,
    label="range stated by the source",
)


def _bounds(name: str, meaning: str, symbol: str, unit: str) -> tuple[Variable, Variable]:
    """The smallest and the largest number of a shot that the sources of a law's range state."""
    low, high = (
        _of_law(
            f"{{quantity}}_law_{name}_{bound}",
            f"{bound} bound of the {meaning} that a source of the law states; NaN: none",
            lambda choice, place=place: choice.law.range.bounds(symbol)[place],
            unit=unit,
            label=f"{meaning}, {bound} bound of the law",
        )
        for place, bound in enumerate(("lower", "upper"))
    )
    return low, high


LAW_SPEEDS = _bounds("speed", "speed", SPEED, "m s-1")
LAW_THICKNESS_RATIOS = _bounds("thickness_ratio", "t/d", THICKNESS_RATIO, "1")
LAW_CONFIDENCE = _text_of_law(
    "{quantity}_law_confidence", "confidence in the equation", lambda choice: EQUATION + choice.law.confidence
)
LAW_SCATTER = _of_law(
    "{quantity}_law_scatter",
    "published scatter of measured values about the law, relative standard deviation; NaN: not published",
    lambda choice: choice.law.scatter,
    unit="1",
    label="relative scatter about the law",
)
OF_ANSWERS = (BY_LAW, BY_LAW_IN_RANGE, BY_LAW_STATUS, BY_LAW_REASON)
OF_LAWS = (
    *(LAW_VARIANT, LAW_NAME, LAW_TITLE, LAW_EQUATION, LAW_SOURCE, LAW_RANGE, LAW_HAS_RANGE),
    *(*LAW_SPEEDS, *LAW_THICKNESS_RATIOS, LAW_CONFIDENCE, LAW_SCATTER),
)


# ---- of observed shots: a record is a shot, a law, or its answer ---------------------------------

_of_shot = partial(Variable, dims=(OBSERVATION,), group="observations")

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
    "{quantity}_observed", "{meaning}, as observed", lambda shot: shot.value, unit="{unit}", label="{words}, observed"
)
OBSERVED_UNCERTAINTY = _of_shot(
    "{quantity}_observed_uncertainty",
    "uncertainty of {quantity}_observed, as stated",
    lambda shot: shot.uncertainty,
    unit="{unit}",
    label="{words}, shot error",
)
OBSERVED_BOUNDS = tuple(
    _of_shot(
        f"{{quantity}}_observed_{bound}",
        f"{bound} bound of {{quantity}} where a range alone is published",
        lambda shot, place=place: shot.bounds and shot.bounds[place],
        unit="{unit}",
        label=f"{{words}}, {bound} bound",
    )
    for place, bound in enumerate(("lower", "upper"))
)
_of_observed_law = partial(replace, dims=(OBSERVED_LAW,), group="observations")
OBSERVED_LAW_TITLE = _of_observed_law(LAW_TITLE, name="{quantity}_observed_law_title")
OBSERVED_LAW_CONFIDENCE = _of_observed_law(LAW_CONFIDENCE, name="{quantity}_observed_law_confidence")
OF_OBSERVED_LAWS = (
    _of_observed_law(
        LAW_LABEL,
        name=OBSERVED_LAW,
        meaning="law and variant, of those stated for an observed shot",
        label="law and variant of a shot",
    ),
    OBSERVED_LAW_TITLE,
    OBSERVED_LAW_CONFIDENCE,
)
OF_ANSWERS_AT_OBSERVATIONS = tuple(
    replace(
        answer,
        name=answer.name.replace("by_law", "by_law_at_observation"),
        meaning=meaning or answer.meaning,
        label=f"{{words}}, {label}",
        dims=(OBSERVATION, OBSERVED_LAW),
        group="observations",
    )
    for answer, meaning, label in zip(
        OF_ANSWERS,
        (
            "{quantity} by published laws for each shot",
            "",
            "how the answer for each shot stands to the range of the law",
            "why the law is outside its range, or has no answer, for each shot",
        ),
        ("law at shot", "in range", "shot range status", "shot reason"),
        strict=True,
    )
)
