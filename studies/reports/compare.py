"""Simulation, laws and observations side by side: residuals and their statistics.

A residual is "subject minus reference". The reference is the simulation, and where the sweep
brought observed shots the observation as well. Each law is judged twice: wherever it answers, and
inside the range that its source states. A figure over no points is ``n = 0``, never a number.
An error bar of the simulation judges only where the mesh's part is in it: of one grid nobody knows
how far it is off.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, Literal

import numpy as np
import xarray as xr

from studies.reports.places import Place, places_of
from studies.reports.points import comparable, points_of, refined, refinements_of, simulated
from studies.reports.sightings import Sighting, bring_to, sightings_of
from studies.values.formats import display_of, of_share, printed_in

Reference = Literal["simulation", "observation"]

ONLY_SIMULATION = (
    "The reference of every residual here is a simulation, not an experiment: no observed shots "
    "were given. A small residual says that a law and this simulation agree, and nothing about "
    "nature."
)
WITH_OBSERVATIONS = (
    "Residuals are given against the simulation and against the observed shots that the sweep "
    "brought. Only those against observations say how well a law or the simulation describes "
    "nature."
)
NO_MESH = "mesh error is unknown, so that no error bar judges this"
NOT_BOTH = "its mesh error is unknown, or the observation states no error, so that no error bar judges this"


@dataclass(frozen=True)
class Extreme:
    """The largest residual, with its sign, and where it is."""

    value: float
    at: Place  # axis or parameter -> value


@dataclass(frozen=True)
class Statistics:
    """Residuals of one subject over some points."""

    n: int
    bias: float | None = None  # mean, in the unit of the quantity
    rms: float | None = None
    largest: Extreme | None = None
    relative_bias: float | None = None  # of residual / reference
    relative_rms: float | None = None
    relative_largest: Extreme | None = None
    judged: int = 0  # points with an error bar that judges: the mesh's part is in it
    within: int = 0  # of these, where the subject lies inside it
    bar: float | None = None  # median error bar of these, in the unit of the quantity
    relative_bar: float | None = None  # median, over the reference
    converged: int | None = None  # points whose reference is; None where nobody refined


@dataclass(frozen=True)
class Residual:
    """How one subject differs from one reference."""

    quantity: str
    unit: str
    subject: str  # label of a law, or "simulation"
    title: str  # of the law
    reference: Reference
    everywhere: Statistics  # where the subject answers
    in_range: Statistics | None  # inside the law's range; None for the simulation
    points: int  # at which the reference has a value; the subject need not answer at all of them


@dataclass(frozen=True)
class Comparison:
    """Everything that a report says about agreement."""

    statement: str
    residuals: tuple[Residual, ...]
    sightings: tuple[Sighting, ...]

    def as_json(self) -> dict[str, Any]:
        """Plain objects for the report's twin."""
        return {
            "statement": self.statement,
            "residuals": [{**asdict(one), "sentence": sentence(one)} for one in self.residuals],
            "observations": [asdict(sighting) for sighting in self.sightings],
        }


def compare(cube: xr.Dataset) -> Comparison:
    """Compare the simulation of a cube with its laws, and both with its observations, point by point."""
    quantities = str(cube.attrs["quantities"]).split()
    dataset = points_of(cube)
    sightings = tuple(sighting for name in quantities for sighting in sightings_of(dataset, name))
    converged = {name: _converged(cube, name) for name in quantities}
    return Comparison(
        statement=WITH_OBSERVATIONS if sightings else ONLY_SIMULATION,
        residuals=(
            *_against_simulation(dataset, converged),
            *_against_observations(dataset, sightings),
        ),
        sightings=sightings,
    )


def statistics(
    subject: np.ndarray,
    reference: np.ndarray,
    places: Sequence[Place],
    bars: np.ndarray | None = None,
    converged: np.ndarray | None = None,
) -> Statistics:
    """Statistics of ``subject - reference``, arrays (points,), where both are numbers.

    ``bars`` (points,) are the error bars of the reference, NaN where it has none; ``converged`` (points,) says where
    it is.
    """
    known = np.flatnonzero(np.isfinite(subject) & np.isfinite(reference))
    if not len(known):
        return Statistics(0)
    residual = (subject - reference)[known]
    absolute = Statistics(
        n=len(known),
        bias=float(residual.mean()),
        rms=_rms(residual),
        largest=_largest(residual, known, places),
        converged=None if converged is None else int(converged[known].sum()),
        **({} if bars is None else _inside(residual, reference[known], bars[known])),
    )
    sized = (
        reference[known] != 0.0
    )  # nothing is relative to zero: a plate that held has a hole of 0 mm
    if not sized.any():
        return absolute
    relative = residual[sized] / reference[known][sized]
    return replace(
        absolute,
        relative_bias=float(relative.mean()),
        relative_rms=_rms(relative),
        relative_largest=_largest(relative, known[sized], places),
    )


def _inside(residual: np.ndarray, reference: np.ndarray, bars: np.ndarray) -> dict[str, Any]:
    """How many residuals are inside the error bars of their references, and how long those are."""
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


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _largest(values: np.ndarray, known: np.ndarray, places: Sequence[Place]) -> Extreme:
    where = int(np.argmax(np.abs(values)))
    return Extreme(float(values[where]), places[known[where]])


# ---- against the simulation ----------------------------------------------------------------------


def _against_simulation(
    dataset: xr.Dataset, converged: Mapping[str, np.ndarray | None]
) -> Iterator[Residual]:
    places = places_of(dataset)
    for name in converged:
        if f"{name}_by_law" in dataset:
            laws, inside = dataset[f"{name}_by_law"], dataset[f"{name}_by_law_in_range"]
            reference = _Reference(
                "simulation",
                comparable(dataset, name).values.ravel(),
                simulated(_whole(dataset, name), f"{name}_uncertainty").values.ravel(),
                places,
                converged[name],
            )
            yield from _of_laws(dataset, name, laws, inside, reference)


def _whole(dataset: xr.Dataset, name: str) -> xr.Dataset:
    """The points, with error bars of a variable where they hold the mesh's part, else NaN."""
    bars, mesh = f"{name}_uncertainty", f"{name}_converged_uncertainty_mesh"
    known = dataset[mesh].notnull() if mesh in dataset else False
    return dataset.assign({bars: dataset[bars].where(known)})


def _converged(cube: xr.Dataset, name: str) -> np.ndarray | None:
    """Whether a measured variable is converging, (points,); None where nobody refined."""
    if not refinements_of(cube):
        return None
    return np.array([one.verdict == "converging" for one in refined(cube, name)])


@dataclass(frozen=True)
class _Reference:
    """What laws are compared with: arrays (points,)."""

    name: Reference
    values: np.ndarray
    bars: np.ndarray  # NaN where there is no error bar
    places: Sequence[Place]
    converged: np.ndarray | None = None  # bool; None where nobody refined


def _of_laws(
    dataset: xr.Dataset,
    name: str,
    laws: xr.DataArray,
    inside: xr.DataArray,
    reference: _Reference,
) -> Iterator[Residual]:
    labels = str(laws.dims[-1])  # laws at observed shots have labels of their own
    for number, label in enumerate(dataset[labels].values):
        answer = laws.values[..., number].ravel()
        in_range = inside.values[..., number].ravel() == 1

        def judged(values: np.ndarray) -> Statistics:
            return statistics(
                values, reference.values, reference.places, reference.bars, reference.converged
            )

        yield Residual(
            quantity=name,
            unit=dataset[name].attrs["units"],
            subject=str(label),
            title=str(dataset[f"{labels}_title"].values[number]),
            reference=reference.name,
            everywhere=judged(answer),
            in_range=judged(np.where(in_range, answer, np.nan)),
            points=int(np.isfinite(reference.values).sum()),
        )


# ---- against observations ------------------------------------------------------------------------


def _against_observations(dataset: xr.Dataset, sightings: Sequence[Sighting]) -> Iterator[Residual]:
    for name in dict.fromkeys(sighting.quantity for sighting in sightings):
        mine = [sighting for sighting in sightings if sighting.quantity == name]
        places = [sighting.at for sighting in mine]
        seen = np.array([sighting.value for sighting in mine])
        gained = np.array([_nan(sighting.simulation) for sighting in mine])
        bars = np.array([_nan(sighting.uncertainty) for sighting in mine])
        yield Residual(
            name,
            dataset[name].attrs["units"],
            "simulation",
            "simulation",
            "observation",
            everywhere=statistics(gained, seen, places, _joint(_whole(dataset, name), mine)),
            in_range=None,
            points=len(mine),
        )
        if f"{name}_by_law_at_observation" in dataset:
            rows = [sighting.observation for sighting in mine]
            laws = dataset[f"{name}_by_law_at_observation"].isel(observation=rows)
            inside = dataset[f"{name}_by_law_at_observation_in_range"].isel(observation=rows)
            reference = _Reference("observation", seen, bars, places)
            yield from _of_laws(dataset, name, laws, inside, reference)


def _joint(dataset: xr.Dataset, sightings: Sequence[Sighting]) -> np.ndarray:
    """Error bars of simulation and observation together, root of the sum of squares.

    NaN where the observation states none, or the simulation's does not hold the mesh's part.
    """
    seen = [_nan(one.uncertainty) for one in sightings]
    gained = [bring_to(dataset, one.quantity, one.at)[1] for one in sightings]
    return np.hypot(seen, gained)


# ---- words ---------------------------------------------------------------------------------------


def sentence(residual: Residual) -> str:
    """A residual in words: how far, of how many points, and how many inside the error bar."""
    words = residual.quantity.replace("_", " ")
    subject = residual.title if residual.subject != "simulation" else "the simulation"
    variant = residual.subject.partition("/")[2]
    subject += f" ({variant})" if variant else ""
    subject = subject[:1].upper() + subject[1:]
    everywhere, inside = residual.everywhere, residual.in_range
    if not everywhere.n:
        return f"{subject}: no point to compare."
    if inside is None:
        return f"{subject} gives a {words} {_apart(everywhere, residual)}."
    if not inside.n:
        return (
            f"{subject}: no point inside its stated range, so nothing is said about it there; outside, "
            f"its {words} is {_apart(everywhere, residual)}."
        )
    share = "all" if inside.n == residual.points else f"{inside.n} of {residual.points}"
    return (
        f"{subject}, inside its stated range ({share} points), gives a {words} "
        f"{_apart(inside, residual)}."
    )


def _reference(found: Statistics, residual: Residual) -> str:
    """What was observed; or the simulation, and how far it may be called converged where it is compared."""
    if residual.reference == "observation":
        return "what was observed"
    if found.converged is None:
        return "the simulation"
    if found.converged == found.n:
        return "the converged simulation"
    return f"the simulation (converged at {found.converged or 'none'} of {found.n} points)"


def _apart(found: Statistics, residual: Residual) -> str:
    """Mean difference, and whether error bars cover it."""
    unit = residual.unit
    assert found.bias is not None
    if found.relative_bias is not None:
        size = of_share(abs(found.relative_bias))
        length = "" if found.relative_bar is None else of_share(found.relative_bar)
    else:
        size = f"{printed_in(abs(found.bias), unit)} {display_of(unit).unit}"
        length = (
            "" if found.bar is None else f"{printed_in(found.bar, unit)} {display_of(unit).unit}"
        )
    # Of the number that is said: the mean of ratios may have the other sign.
    mean = found.bias if found.relative_bias is None else found.relative_bias
    way = "larger" if mean > 0 else "smaller"
    words = f"on average {size} {way} than {_reference(found, residual)}"
    if found.n == 1:
        words = words.removeprefix("on average ")
    if not found.judged:
        return f"{words}{_unjudged(residual)}"
    bar = "the error bars of both together" if residual.in_range is None else "the error bar"
    return (
        f"{words}; inside {bar} (median ± {length}) at {found.within} of {found.judged} "
        f"point{'s' if found.judged > 1 else ''}"
    )


def _unjudged(residual: Residual) -> str:
    """Why no error bar judges."""
    if residual.reference == "simulation":
        return f", whose {NO_MESH}"
    if residual.subject == "simulation":
        return f"; {NOT_BOTH}"
    return ", which has no error bar"


def _nan(value: float | None) -> float:
    return math.nan if value is None else value
