"""Simulation, laws and observations side by side: residuals and their statistics.

A residual is "subject minus reference". The reference is the simulation, and where the sweep
brought observed shots the observation as well. Each law is judged twice: wherever it answers, and
inside the range that its source states. A figure over no points is ``n = 0``, never a number.
An error bar of the simulation judges only where it includes the mesh error: a single grid does not show
how far off it is.
"""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
import xarray as xr

from studies.cubes import reading
from studies.cubes.points import (
    Place,
    comparable,
    error_bars,
    main_quantities,
    places_of,
    points_of,
    refinements_of,
    verdicts_of,
)
from studies.laws import DRAWN_ONLY
from studies.reports.evidence import LawAnswers, Reference, answers_of, evidence_of
from studies.reports.judgement import Judgement, judgements_of
from studies.reports.matched import MatchedObservation, matched_observations
from studies.reports.shots import MeasuredShot, measured_shots
from studies.reports.unchecked import Unchecked, unchecked
from studies.reports.words import joined, words

UNEVEN = 2.0  # ratio of the largest to the smallest residual beyond which an average hides what they do
MIXED = (
    "The runs of this sweep measured {} by versions {} of its definition, which give different numbers: nothing is "
    "compared with it. `whipple remeasure` reads the stored final states again by the present definition."
)


@dataclass(frozen=True)
class Extreme:
    """The largest residual, with its sign, and where it is."""

    value: float
    at: Place  # axis or parameter -> value


@dataclass(frozen=True)
class Statistics:
    """Residuals of one subject over some points."""

    n: int
    # Mean, in the unit of the quantity; None where residuals change sign or vary by more than a factor of two.
    bias: float | None = None
    smallest: float | None = None  # with its sign
    greatest: float | None = None
    rms: float | None = None
    largest: Extreme | None = None
    relative_bias: float | None = None  # bias of residual / reference
    relative_smallest: float | None = None
    relative_greatest: float | None = None
    relative_rms: float | None = None
    relative_largest: Extreme | None = None
    judged: int = 0  # points with an error bar that judges: it includes the mesh error
    within: int = 0  # number of these inside the error bar
    bar: float | None = None  # median error bar of these, in the unit of the quantity
    relative_bar: float | None = None  # median, over the reference
    converged: int | None = None  # points whose reference is; None where nobody refined


@dataclass(frozen=True)
class Residual:
    """Difference of one subject from one reference."""

    quantity: str
    unit: str
    subject: str  # label of a law, or "simulation"
    title: str  # of the law
    reference: Reference
    everywhere: Statistics  # where the subject answers
    in_range: Statistics | None  # inside the law's range; None for the simulation
    points: int  # at which the reference has a value; the subject need not answer at all of them
    drawn_only: str = ""  # why the law enters no average and no verdict; empty where it does
    no_range: bool = False  # whether the source of the law states none


@dataclass(frozen=True)
class Comparison:
    """Everything that a report says about agreement."""

    points: xr.Dataset  # of the cube: those that are compared
    residuals: tuple[Residual, ...]
    observations: tuple[MatchedObservation, ...]
    judgements: tuple[Judgement, ...]
    shots: tuple[MeasuredShot, ...]  # that a point repeats
    unchecked: tuple[Unchecked, ...]
    # Quantities with which nothing is compared because their runs mix versions of the definition; the sentence for it.
    mixed: Mapping[str, str]

    def as_json(self) -> dict[str, Any]:
        """Plain objects for the report."""
        return {
            "judgements": [each.as_json() for each in self.judgements],
            "shots": [each.as_json() for each in self.shots],
            "unchecked": [asdict(each) for each in self.unchecked],
            "residuals": [asdict(each) for each in self.residuals],
            "observations": [asdict(each) for each in self.observations],
            "mixed": [{"quantity": name, "sentence": text} for name, text in self.mixed.items()],
        }


@dataclass(frozen=True)
class References:
    """Values that subjects are compared with: arrays (points,)."""

    kind: Reference
    values: np.ndarray
    places: Sequence[Place]
    bars: np.ndarray | None = None  # NaN where there is no error bar that judges
    converged: np.ndarray | None = None  # bool; None where nobody refined


def compare(cube: xr.Dataset) -> Comparison:
    """Compare the simulation of a cube with its laws, and both with its observations, point by point."""
    points = points_of(cube)
    against_simulation: list[Residual] = []
    against_observations: list[Residual] = []
    observations: list[MatchedObservation] = []
    for name in reading.quantities_of(cube):
        against_simulation += _against_simulation(cube, points, name)
        mine = list(matched_observations(points, name))
        alike = [shot for shot in mine if shot.is_alike]
        against_observations += _against_observations(points, name, alike)
        observations += mine
    evidence = [each for each in evidence_of(points, [shot for shot in observations if shot.is_alike]) if each.subjects]
    return Comparison(
        points=points,
        residuals=(*against_simulation, *against_observations),
        observations=tuple(observations),
        judgements=tuple(judgement for each in evidence for judgement in judgements_of(each)),
        shots=tuple(shot for name in main_quantities(points) for shot in measured_shots(points, name, observations)),
        unchecked=unchecked(evidence),
        mixed=mixed(cube),
    )


def published_shots(cube: xr.Dataset) -> list[dict[str, Any]]:
    """Groups of published shots with the bias of whipple itself."""
    groups: list[dict[str, Any]] = json.loads(cube.attrs["compared_shots"])
    return groups


def mixed(cube: xr.Dataset) -> dict[str, str]:
    """Quantities whose runs mix versions of the definition, with the sentence that says so and names the cure."""
    versions = {name: reading.mixed_versions(cube, name) for name in reading.quantities_of(cube)}
    return {name: MIXED.format(words(name), joined(list(map(str, each)))) for name, each in versions.items() if each}


def is_uneven(residuals: np.ndarray) -> bool:
    """Whether an average would hide what residuals do: they change sign, or vary by more than ``UNEVEN``.

    >>> [is_uneven(np.array(pair)) for pair in ((-0.1, 0.1), (0.1, 0.3), (0.1, 0.2))]
    [True, True, False]
    """
    if residuals.size < 2:
        return False
    sizes = np.abs(residuals)
    return bool(residuals.min() < 0.0 < residuals.max() or sizes.max() > UNEVEN * sizes.min())


def statistics(subject: np.ndarray, reference: References) -> Statistics:
    """Statistics of a subject, (points,), minus its reference, where both are numbers."""
    answered = np.flatnonzero(np.isfinite(subject) & np.isfinite(reference.values))
    if not len(answered):
        return Statistics(0)
    expected = reference.values[answered]
    residual = subject[answered] - expected
    absolute = Statistics(
        n=len(answered),
        bias=_average(residual),
        smallest=float(residual.min()),
        greatest=float(residual.max()),
        rms=_rms(residual),
        largest=_largest(residual, answered, reference.places),
        converged=None if reference.converged is None else int(reference.converged[answered].sum()),
        **({} if reference.bars is None else _inside(residual, expected, reference.bars[answered])),
    )
    # Nothing is relative to zero: a plate that held has a hole of 0 mm.
    sized = expected != 0.0
    if not sized.any():
        return absolute
    relative = residual[sized] / expected[sized]
    average = _average(relative)
    return replace(
        absolute,
        bias=None if average is None else absolute.bias,
        relative_bias=average,
        relative_smallest=float(relative.min()),
        relative_greatest=float(relative.max()),
        relative_rms=_rms(relative),
        relative_largest=_largest(relative, answered[sized], reference.places),
    )


def without_averages(summary: Statistics) -> Statistics:
    """The statistics of a law that enters no average: its ends and its largest residual; one point is no average."""
    if summary.n < 2:
        return summary
    return replace(summary, bias=None, rms=None, relative_bias=None, relative_rms=None)


def _inside(residual: np.ndarray, reference: np.ndarray, bars: np.ndarray) -> dict[str, Any]:
    """Count the residuals inside the error bars of their references; median length of those."""
    barred = np.isfinite(bars)
    if not barred.any():
        return {}
    sized = barred & (reference != 0.0)
    relative = float(np.median(bars[sized] / np.abs(reference[sized]))) if sized.any() else None
    return {
        "judged": int(barred.sum()),
        "within": int((np.abs(residual[barred]) <= bars[barred]).sum()),
        "bar": float(np.median(bars[barred])),
        "relative_bar": relative,
    }


def _average(residuals: np.ndarray) -> float | None:
    """The mean; None where it would hide what the residuals do."""
    return None if is_uneven(residuals) else float(residuals.mean())


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _largest(values: np.ndarray, points: np.ndarray, places: Sequence[Place]) -> Extreme:
    where = int(np.argmax(np.abs(values)))
    return Extreme(float(values[where]), places[points[where]])


# ---- residuals -----------------------------------------------------------------------------------


def _against_simulation(cube: xr.Dataset, points: xr.Dataset, name: str) -> Iterator[Residual]:
    """Each law against the simulation."""
    settled = None
    if refinements_of(cube):
        settled = np.isin(verdicts_of(cube, name).values.ravel(), ("converging", "mesh error known"))
    reference = References(
        "simulation",
        comparable(points, name).values.ravel(),
        places_of(points),
        error_bars(points, name).values.ravel(),
        settled,
    )
    yield from (_of_law(name, law, reference) for law in answers_of(points, name))


def _against_observations(points: xr.Dataset, name: str, shots: Sequence[MatchedObservation]) -> Iterator[Residual]:
    """The simulation and each law against the observed shots of a quantity."""
    if not shots:
        return
    places = [shot.at for shot in shots]
    values = np.array([shot.observed for shot in shots])
    # NaN where the observation states none, or the mesh error of the simulation is unknown.
    bars, own = np.array([(shot.uncertainty, shot.simulation_uncertainty) for shot in shots], float).T
    simulated = np.array([shot.simulation for shot in shots], float)
    yield Residual(
        quantity=name,
        unit=points[name].attrs["units"],
        subject="simulation",
        title="simulation",
        reference="observation",
        everywhere=statistics(simulated, References("observation", values, places, np.hypot(bars, own))),
        in_range=None,
        points=len(shots),
    )
    reference = References("observation", values, places, bars)
    for law in answers_of(points, name, [shot.observation for shot in shots]):
        yield _of_law(name, law, reference)


def _of_law(name: str, law: LawAnswers, reference: References) -> Residual:
    drawn_only = DRAWN_ONLY.get(law.confidence, "")
    everywhere = statistics(law.answers, reference)
    ranged = statistics(np.where(law.inside, law.answers, np.nan), reference)
    if drawn_only:
        everywhere, ranged = without_averages(everywhere), without_averages(ranged)
    return Residual(
        quantity=name,
        unit=law.unit,
        subject=law.label,
        title=law.title,
        reference=reference.kind,
        everywhere=everywhere,
        in_range=ranged,
        points=int(np.isfinite(reference.values).sum()),
        drawn_only=drawn_only,
        no_range=law.has_range is False,
    )
