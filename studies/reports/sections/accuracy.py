"""How good the numbers are: grids, orders and parts of each error bar; and what material data and models leave open."""

from collections.abc import Mapping
from dataclasses import dataclass

from studies.reports.records import Place
from studies.reports.section import Section, when_called


@dataclass(frozen=True)
class GridLevel:
    """The runs of one resolution at a point."""

    spacing: float  # of cells, over the projectile's diameter
    value: float | None
    scatter: float | None  # over offsets
    values: int
    runs: int


@dataclass(frozen=True)
class PointConvergence:
    """The value of a quantity at a point with the parts of its error bar; SI."""

    at: Place
    verdict: str
    value: float | None
    uncertainty: float | None  # None where the mesh error is unknown
    mesh: float | None
    measurement: float | None
    model: float | None  # strength and equation of state, standard uncertainty
    lower: float | None  # how far failures that count move it down and up
    upper: float | None
    raw: float | None = None  # as read off the mesh, before the correction for it; None where there is no correction
    # Of several grids.
    reason: str = ""
    offsets: float | None = None
    order: float | None = None
    extrapolated: float | None = None
    gci: float | None = None
    levels: tuple[GridLevel, ...] = ()  # coarsest first


@dataclass(frozen=True)
class QuantityConvergence:
    """A quantity at each point."""

    quantity: str
    unit: str
    main: bool
    points: tuple[PointConvergence, ...]


@dataclass(frozen=True)
class Convergence:
    """Each quantity, with the resolutions of the sweep and how many offsets each has."""

    rules: str  # by which several grids tell a mesh error
    resolutions: tuple[float, ...]  # cells across the projectile's diameter; empty of one
    offsets: int
    quantities: tuple[QuantityConvergence, ...]


@dataclass(frozen=True)
class Side:
    """How far failures that count move a value to one side."""

    share: float | None  # of the value
    failure: str


@dataclass(frozen=True)
class ModelPart:
    """What the models leave open of a quantity at some runs."""

    quantity: str
    statement: str  # with its source, or why nothing is assessed
    contributions: Mapping[str, float | None]  # relative standard uncertainties
    lower: Side | None
    upper: Side | None
    thrown_out: tuple[str, ...]  # failures that do not count
    distance: float | None  # largest factor by which the runs are outside of where it was measured
    runs: int


@dataclass(frozen=True)
class Models:
    """The model part of each quantity."""

    parts: tuple[ModelPart, ...]


SECTION = (
    Section(
        "convergence",
        "Accuracy",
        50,
        Convergence,
        when_called("studies.reports.sections._accuracy:convergence_of"),
        "sections/convergence.html",
        appendix="sections/convergence_appendix.html",
    ),
    Section(
        *("models", "Uncertainty of the models", 60, Models),
        when_called("studies.reports.sections._accuracy:models_of"),
        appendix="sections/models_appendix.html",
    ),
)
