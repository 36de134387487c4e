"""The verdict: its words on cubes whose answer is known, and on others as they are recomputed from cube.nc."""

import json
import math
import re
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from studies.cubes import cube
from studies.laws import NO_RANGE, NOT_FOUND
from studies.reports.compare import compare
from studies.runs.results import RunResult
from tests.studies.support import fakes
from tests.studies.support.headlines import ends_of

NAME = "hole_diameter"
MOST = 0.10  # the difference up to which the report calls a law numerically close, or within so much
CLOSE = ("meets the simulation", "close")
PERCENT = re.compile(r"(\d+(?:\.\d+)?)(?: to (\d+(?:\.\d+)?))?\u202f%")
NUMBER = re.compile(r"[-−+]?\d+(?:\.\d+)?")
BAR = 0.002  # relative mesh error of the invented points

# ---- words ---------------------------------------------------------------------------------------

Change = Callable[[RunResult], RunResult]


def ratio(speed: float) -> float:
    """Hole over projectile of every invented run."""
    return 2.0 * speed / 5e3


def document_of(
    factor: Callable[[float], float],
    speeds: tuple[float, ...] = fakes.SPEEDS,
    change: Change = lambda result: result,
    *,
    rangeless: bool = False,
    scatter: float | None = None,
    edit: Callable[[xr.Dataset], xr.Dataset] = lambda cube: cube,
) -> dict[str, Any]:
    """The comparison of the invented holes, on grids of first order, with a law that gives them times a factor."""
    limits = fakes.within(0.0, math.inf, *([NOT_FOUND] if rangeless else []))
    law = fakes.law(
        "law",
        NAME,
        lambda shot, _: ratio(shot.speed) * factor(shot.speed),
        title="the law",
        range=limits,
        scatter=scatter,
    )
    axis = fakes.Axis("speed", "m s-1", speeds)
    sweep = fakes.sweep_of(axis, resolutions=fakes.CELLS, model_part="none")
    results = {point.run.id: change(result(point.run)) for point in sweep.runs()}
    return compare(edit(fakes.cube_of(sweep, results, laws=[law], quantities={NAME: fakes.HOLES[NAME]}))).as_json()


def result(run: Any) -> RunResult:
    value = ratio(run.parameters["speed"]) * fakes.DIAMETER
    return replace(fakes.result(run), measurements={NAME: fakes.of_first_order(value, BAR, run)})


def stated(*arguments: Any, **named: Any) -> tuple[list[str], dict[str, Any]]:
    """The bands of the only law in words, and the verdict on the quantity."""
    (quantity,) = document_of(*arguments, **named)["verdict"]["quantities"]
    (law,) = quantity["laws"]
    return [f"{band['where']}: {band['says']}" for band in law["bands"]], quantity


MEETS = "meets the simulation: no difference, ±0.2 %"


@pytest.mark.claim("report", "verdict-words")
@pytest.mark.parametrize(
    ("factor", "bands", "headline"),
    [
        (
            lambda v: 1.0,
            [f"from 2 to 7 km/s: {MEETS}"],
            "2-7 km/s: use the law, no difference, ±0.2 %; simulation only.",
        ),
        (
            lambda v: 0.8 if v > 5e3 else 1.0,
            [f"up to 5 km/s: {MEETS}", "from 6 km/s: too low: 20 % low, ±0.2 %"],
            "2-7 km/s: trust none; the exponent of its one law is refuted; simulation only.",
        ),
        (
            lambda v: 1.2 if v > 5e3 else 1.0,
            [f"up to 5 km/s: {MEETS}", "from 6 km/s: too high: 20 % high, ±0.2 %"],
            "2-7 km/s: trust none; the exponent of its one law is refuted; simulation only.",
        ),
        (
            lambda v: 1.3 if v == 4e3 else 1.0,
            [f"up to 3 km/s: {MEETS}", "at 4 km/s: too high: 30 % high, ±0.2 %", f"from 5 km/s: {MEETS}"],
            "2-7 km/s: trust none; the exponent of its one law is refuted; simulation only.",
        ),
        (
            lambda v: 1.05,
            ["from 2 to 7 km/s: close: 5 % high, ±0.2 % (beyond the joint uncertainty)"],
            "2-7 km/s: trust none; nearest the law, 5 % high, 6 of 6 points reject; simulation only.",
        ),
        (
            lambda v: 1.05 if v < 2.5e3 else 1.0,
            ["from 2 to 7 km/s: close: 0 to 5 % high, ±0.2 % (beyond the joint uncertainty at 1 of 6 points)"],
            "2-7 km/s: trust none; the exponent of its one law is refuted; simulation only.",
        ),
    ],
    ids=["exact", "low above 5 km/s", "high above 5 km/s", "high at 4 km/s", "5 % high", "5 % high at 2 km/s"],
)
def test_law_of_known_difference__gets_its_words(
    factor: Callable[[float], float], bands: list[str], headline: str
) -> None:
    """A law whose difference from the simulation is known gets the right words: exact, low or high, or close.

    A law off by more than its uncertainty is close at best; a contradicted point divides bands.
    """
    words, quantity = stated(factor)
    assert words == [each.replace(" %", "\u202f%") for each in bands]
    assert quantity["headline"] == headline.replace(" %", "\u202f%")
    if len({factor(speed) for speed in fakes.SPEEDS}) == 1:
        assert ("meets the simulation" in json.dumps(quantity)) == ("meets the simulation" in bands[0])


@pytest.mark.claim("report", "verdict-words")
def test_single_point__is_called_one() -> None:
    """One point, and a law without a stated range, are called that."""
    words, quantity = stated(lambda v: 1.0, speeds=(5e3,))
    assert words == [f"at 5 km/s: {MEETS}".replace(" %", "\u202f%")]
    assert "At the one judged point no difference" in " ".join(quantity["laws"][0]["details"])
    document = document_of(lambda v: 1.0, rangeless=True)
    assert document["verdict"]["quantities"][0]["laws"][0]["no_range"] == NO_RANGE


@pytest.mark.claim("report", "verdict-words")
@pytest.mark.parametrize(
    ("changes", "why"),
    [
        ({"state": "failed", "reason": "no"}, "the run failed"),
        ({"flags": ("under_resolved",)}, "flagged as under resolved"),
    ],
    ids=["failed", "flagged"],
)
def test_runs_without_a_value_or_flagged__judge_nothing(changes: dict[str, Any], why: str) -> None:
    """Where every run failed or is flagged, no law is judged, and the headline says that."""
    document = document_of(lambda v: 1.0, change=lambda result: replace(result, **changes))
    (quantity,) = document["verdict"]["quantities"]
    (band,) = quantity["laws"][0]["bands"]
    assert f"{band['where']}: {band['says']}" == f"from 2 to 7 km/s: not judged: {why}"
    none = "is flagged as under-resolved" if "flags" in changes else "in the range of a law failed"
    assert document["verdict"]["headline"] == f"No verdict: every finest run {none}."
    flagged = "6 of 6 points flagged, drawn open, and not judged: under resolved 6."
    assert (flagged in document["verdict"]["unchecked"]) == ("flags" in changes)


@pytest.mark.claim("report", "verdict-words")
def test_residuals_of_mixed_sign__have_a_trend_and_no_average() -> None:
    """Residuals of mixed sign have a trend with its interval, and no average anywhere in the report."""
    document = document_of(lambda v: 1.0 + (v - 4500.0) / 5e4)
    (quantity,), (residual,) = document["verdict"]["quantities"], document["residuals"]
    (law,) = quantity["laws"]
    (band,) = law["bands"]
    assert band["says"] == "close: 5\u202f% low to 5\u202f% high, ±0.2\u202f% (beyond the joint uncertainty)"
    assert "no average is given; linear trend over 6 points: +2.0 ±" in law["details"][0]
    assert law["average"] is residual["everywhere"]["bias"] is residual["everywhere"]["relative_bias"] is None


@pytest.mark.claim("report", "verdict-words")
def test_mixed_versions_of_a_measurement__judge_nothing() -> None:
    """Runs whose measurement mixes versions of its definition get no verdict."""
    versions = iter(range(100))

    def versioned(result: RunResult) -> RunResult:
        return fakes.of_version(result, NAME, 1 + next(versions) % 2)

    verdict = document_of(lambda v: 1.0, change=versioned)["verdict"]
    assert verdict["headline"] == "No verdict: runs measured hole diameter by different definitions; remeasure them."
    assert not verdict["quantities"]


def with_failures(cube: xr.Dataset, lower: float = 0.0, upper: float = 0.0, symmetric: float = 0.0) -> xr.Dataset:
    """The cube with a model part, relative to each value, whose sides two failures make."""
    sides = {"lower": (lower, "lower-failure"), "upper": (upper, "upper-failure")}
    sizes = {f"{NAME}_model_part_{side}": share * cube[NAME] for side, (share, _) in sides.items()}
    names = {
        f"{NAME}_model_part_{side}_failure": xr.full_like(cube[NAME], name if share else "", dtype=object)
        for side, (share, name) in sides.items()
    }
    return cube.assign({**sizes, **names, f"{NAME}_model_part": symmetric * cube[NAME]})


@pytest.mark.parametrize(
    ("factor", "part", "hanging"),
    [
        (1.05, {"upper": 0.06}, [("upper-failure", True)]),
        (1.05, {"upper": 0.04}, []),  # still beyond
        (0.95, {"upper": 0.06}, []),  # the other side
        (0.95, {"lower": 0.06, "upper": 0.06}, [("lower-failure", True)]),
        (1.0, {"upper": 0.06}, [("upper-failure", False)]),
        (1.0, {"lower": 0.05, "upper": 0.06}, [("lower-failure", False), ("upper-failure", False)]),
        (1.0, {"upper": 0.06, "symmetric": 0.08}, []),  # inside of the bar with it and without
        (1.05, {}, []),
    ],
)
def test_failure__that_alone_decides_whether_a_law_agrees_is_said(
    factor: float, part: dict[str, float], hanging: list[tuple[str, bool]]
) -> None:
    """Bars and words do not count what failures make of a value; the law says where they would decide."""
    plain = {name: share for name, share in part.items() if name == "symmetric"}
    documents = [document_of(lambda v: factor, edit=partial(with_failures, **each)) for each in (part, plain)]
    laws = [document["verdict"]["quantities"][0]["laws"][0] for document in documents]
    assert laws[0]["bands"] == laws[1]["bands"]
    for point in laws[0]["each"]:
        assert [(each["failure"], each["agrees"]) for each in point["hangs_on"]] == hanging
    said = [text for text in laws[0]["details"] if text not in laws[1]["details"]]
    assert len(said) == bool(hanging)
    for failure, agrees in hanging:
        assert f"{'Inside' if agrees else 'Beyond'} it only if matter breaks by {failure}," in said[0]
        assert "at 6 of 6 tested points" in said[0]


# ---- from cube.nc alone --------------------------------------------------------------------------

# A law whose residuals change sign along the speed and rise with it.
TILTED = fakes.law(
    "tilted", NAME, lambda shot, _: (0.8 + 0.05 * shot.speed / 1e3) * fakes.HOLE_LAWS[1].ratio(shot, ""), title="tilted"
)
# The run of a point that its numbers without a converged value are of.
FINEST = {"cells_per_diameter": -1, "offset": 0}
# What was not checked: counted by hand from the invented runs.
NO_SHOT = "No measured shot was given, so nothing here was compared with nature."
NO_SCATTER = "The sources of the laws publish no scatter."
ELSEWHERE = (
    "What other material data and models change was measured at other speeds or plates (t/d) for {} points, up to a "
    "factor of {} away."
)
FLAGGED = "2 of 18 points flagged, drawn open, and not judged: under resolved 1 and not perforated 1."
RECALLED = (
    "General form with the sound speed: the authors of whipple recalled the equation from memory and compared it with "
    "independent numbers; they did not read the paper."
)
SENTENCES = {
    "holes": [
        NO_SHOT,
        "The mesh error is unknown at 15 of 15 points.",
        ELSEWHERE.format("11 of 15", 2),
        NO_SCATTER,
        FLAGGED,
        RECALLED,
    ],
    "refined": [
        NO_SHOT,
        "The mesh error is unknown at 4 of 6 points.",
        ELSEWHERE.format("1 of 6", 1.5),
        NO_SCATTER,
        RECALLED,
    ],
    "craters": [
        NO_SHOT,
        "The mesh error is unknown at 4 of 4 points.",
        "Nobody assessed how much another definition of the measured quantity would change it.",
        NO_SCATTER,
    ],
}
SWEEPS = {"holes": fakes.holes(), "refined": fakes.refined_holes(), "craters": fakes.craters()}


@pytest.mark.claim("report", "verdict-sentences")
@pytest.mark.parametrize("case", SWEEPS)
def test_verdict__is_that_of_cube_nc(case: str, tmp_path: Path) -> None:
    """Words, numbers and bands of each law in the verdict are recomputed from cube.nc with xarray and numpy alone."""
    sweep = SWEEPS[case]
    results = fakes.results(sweep) if case == "craters" else fakes.with_trouble(sweep)
    more = {"laws": (*fakes.HOLE_LAWS, TILTED)} if case == "holes" else {}
    file = cube.write(fakes.cube_of(sweep, results, **more), tmp_path / "cube.nc")
    with xr.open_dataset(file) as dataset:
        verdict = compare(dataset).as_json()["verdict"]
        assert list(verdict["unchecked"]) == SENTENCES[case]
        judged = 0
        for quantity in verdict["quantities"]:
            points = points_of(dataset, quantity["quantity"])
            for law in quantity["laws"]:
                frame = points.sel({f"{quantity['quantity']}_law": law["subject"]})
                words = [word_at(frame, each) for each in law["each"]]
                assert [each["word"] for each in law["each"]] == words
                assert len(words) == frame.residual.size
                check_bands(law["bands"], frame)
                check_details(law["details"], frame)
                judged += law["judged"]
        assert judged


def points_of(dataset: xr.Dataset, name: str) -> xr.Dataset:
    """Residual, relative uncertainty, range and usability of each point and law, from the cube alone."""
    refined = f"{name}_converged" in dataset
    value = dataset[f"{name}_converged"] if refined else dataset[name].where(dataset.run_state == 0)
    bar = dataset[f"{name}_converged_uncertainty" if refined else f"{name}_reading_uncertainty"]
    flags = (dataset[f"{name}_flags"] != 0) | (dataset.run_flags != 0)
    for dim in set(flags.dims) - set(value.dims):
        # The flags of a point are those of its finest runs, at any offset.
        flags = flags.isel({dim: -1}) if dim == "cells_per_diameter" else flags.any(dim)
    for part in ("definition", "model"):
        if f"{name}_{part}_part" in dataset:
            known = dataset[f"{name}_{part}_part"].isel(FINEST, missing_dims="ignore")
            bar = (bar**2 + known.fillna(0.0) ** 2) ** 0.5
    mesh = dataset[f"{name}_converged_uncertainty_mesh"] if refined else value * np.nan
    return xr.Dataset(
        {
            "residual": dataset[f"{name}_by_law"] / value - 1.0,
            "bar": bar / value,
            "tests": mesh.notnull(),
            "inside": (dataset[f"{name}_by_law_in_range"] == 1) & dataset[f"{name}_by_law"].notnull(),
            "usable": value.notnull() & ~flags,
            "value": value,
            "law": dataset[f"{name}_by_law"],
        }
    )


def word_at(frame: xr.Dataset, each: Mapping[str, Any]) -> str:
    """The word of a point by its definition, whose numbers are those of the cube."""
    at = frame.sel({name: each["at"][name] for name in frame.dims})
    for number, variable in ((each["predicted"], at.law), (each["reference"], at.value)):
        assert number == float(variable) or (number is None and np.isnan(variable))
    if not at.inside:
        return "outside"
    if not at.usable:
        return "unjudged"
    size, bar, tests = abs(float(at.residual)), float(at.bar.fillna(0.0)), bool(at.tests)
    if max(size, bar) <= MOST:
        return "numerically" if tests and size <= bar else "within"
    if size <= bar:
        return "agrees" if tests else "unjudged"
    return "under" if at.residual < 0 else "over"


def check_bands(bands: list[dict[str, Any]], frame: xr.Dataset) -> None:
    """Each band's words hold at the points that its own text selects, and bands cover every point once."""
    covered = 0
    for band in bands:
        mask = selected(band["where"], frame)
        covered += int(mask.sum())
        judged = mask & frame.inside & frame.usable
        residual, bar, tests = (frame[key].broadcast_like(mask).where(judged) for key in ("residual", "bar", "tests"))
        sizes, says = abs(residual), band["says"]
        beyond = int(((sizes > bar) & (tests == 1.0)).sum())
        if says.startswith("outside its range"):
            assert not (mask & frame.inside).any()
        elif says.startswith("not judged") and "±" not in says:
            assert not judged.any()
        else:
            assert judged.any()
            assert not (mask & ~frame.inside).any()
            ends = [round(100.0 * float(end)) for end in (residual.min(), residual.max())]
            gives, _, spread = says.partition(": ")[2].partition(", ±")
            said = ends_of(gives.replace("\u202f", " "))
            assert all(abs(end - exact) <= 0.5 for end, exact in zip(said, ends, strict=True))
            assert bool(spread) == bool(bar.fillna(0.0).max())
            assert not spread or abs(float(NUMBER.findall(spread)[0]) - 100.0 * float(bar.max())) <= 0.501
            if says.startswith(CLOSE):
                assert max(float(sizes.max()), float(bar.fillna(0.0).max())) <= MOST
                assert (band["word"] == "numerically") == says.startswith("meets")
                assert (band["word"] == "numerically") == (not beyond and bool((tests != 0.0).all()))
                counted = re.search(r"beyond the joint uncertainty(?: at (\d+) of (\d+) points)?", says)
                assert bool(counted) == bool(beyond)
                if counted:
                    assert (int(counted[1] or beyond), int(counted[2] or judged.sum())) == (beyond, int(judged.sum()))
            elif says.startswith(("covered by", "not judged")):
                assert ((sizes <= bar) & (bar > MOST) | ~judged).all()
            else:
                sign = -1.0 if says.startswith("too low") else 1.0
                assert ((sign * residual > np.maximum(MOST, bar.fillna(0.0))) | ~judged).all()
    assert covered == frame.residual.size


def selected(text: str, frame: xr.Dataset) -> xr.DataArray:
    """The points that a text selects: "up to 5 km/s with plate thickness 2 and 3 mm"."""
    along, _, others = text.partition(" with ")
    numbers = [1e3 * float(each) for each in NUMBER.findall(along)]
    low, high = numbers[0], numbers[-1]
    if along.startswith("up to"):
        low = -math.inf
    elif along.startswith("from") and len(numbers) == 1:
        high = math.inf
    mask = (frame.speed >= 0.999999 * low) & (frame.speed <= 1.000001 * high)
    if others:
        near = [np.isclose(frame.plate_thickness, 1e-3 * float(each)) for each in NUMBER.findall(others)]
        mask = mask & xr.zeros_like(frame.plate_thickness, dtype=bool).copy(data=np.any(near, axis=0))
    return mask.broadcast_like(frame.residual)


EXPONENT = re.compile(r"of speed (?:([\d.]+) ±|not determined \(interval (\S+) to (\S+)\)) .+ against (\S+) in the law")


def check_details(details: list[str], frame: xr.Dataset) -> None:
    """Averages, slopes along the speed, exponents and agreement are numpy's own."""
    judged = (frame.inside & frame.usable).values.ravel()
    flat = {key: frame[key].broadcast_like(frame.residual).values.ravel()[judged] for key in (*frame, "speed")}
    residual = flat["residual"]
    for text in details:
        if text.startswith(("On average", "At the one")):
            assert float(PERCENT.findall(text)[0][0]) == pytest.approx(100.0 * abs(residual.mean()), abs=0.5)
            assert residual.min() * residual.max() > 0
        elif text.startswith("From"):
            assert residual.min() < 0 < residual.max() or np.ptp(np.log2(np.abs(residual))) > 1.0
            if "plate_thickness" not in frame.dims and (slope := re.search(r"([+−][\d.]+) ± \S+ percentage", text)):
                expected = 1e5 * np.polyfit(flat["speed"], residual, 1)[0]
                assert float(slope[1].replace("−", "-")) == pytest.approx(expected, abs=0.0501)
        elif text.startswith("Exponents") and "plate_thickness" not in frame.dims:
            fitted = {key: np.polyfit(np.log(flat["speed"]), np.log(flat[key]), 1)[0] for key in ("value", "law")}
            words = EXPONENT.search(text)
            assert words
            value, low, high, law = words.groups()
            if value is None:
                ends = [float(end.replace("−", "-")) for end in (low, high)]
                assert ends[0] <= 0.0 < ends[1]  # as far as two digits tell
                value = 0.5 * sum(ends)
            assert float(value) == pytest.approx(fitted["value"], abs=0.00501)
            over, _, under = law.partition("/")
            assert float(over) / float(under or 1) == pytest.approx(fitted["law"], abs=0.00501)
        elif text.startswith("Inside"):
            counts = [int((np.abs(residual) <= flat["bar"])[flat["tests"]].sum()), int(flat["tests"].sum())]
            assert [int(each) for each in NUMBER.findall(text)[:2]] == counts
