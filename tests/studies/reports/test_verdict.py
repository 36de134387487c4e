"""The verdict: its words on cubes whose answer is known, and on others as they are recomputed from cube.nc."""

import json
import math
import re
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from studies.cubes import cube
from studies.laws import NO_RANGE, NOT_FOUND
from studies.quantities.measured import Measured
from studies.reports.compare import compare
from studies.runs.results import RunResult
from tests.studies.support import fakes

NAME = "hole_diameter"
MOST = 0.10  # the difference up to which the report calls a law numerically close, or within so much
CLOSE = ("numerically", "within")
PERCENT = re.compile(r"(\d+(?:\.\d+)?)(?: to (\d+(?:\.\d+)?))?\u202f%")
NUMBER = re.compile(r"[-−+]?\d+(?:\.\d+)?")
BAR = 0.001  # relative uncertainty of the invented runs

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
) -> dict[str, Any]:
    """The comparison of the invented holes, the same on every grid, with a law that gives them times a factor."""
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
    catalogue = fakes.catalogue()
    catalogue = replace(catalogue, laws=(law,), quantities={NAME: catalogue.quantities[NAME]})
    return compare(cube.build(sweep, results, catalogue)).as_json()


def result(run: Any) -> RunResult:
    value = ratio(run.parameters["speed"]) * fakes.DIAMETER
    measured = Measured(value, BAR * value, {"resolution": BAR * value}, (), {}, 1)
    return replace(fakes.result(run), measurements={NAME: measured})


def stated(*arguments: Any, **named: Any) -> tuple[list[str], dict[str, Any]]:
    """The bands of the only law in words, and the verdict on the quantity."""
    (quantity,) = document_of(*arguments, **named)["verdict"]["quantities"]
    (law,) = quantity["laws"]
    return [f"{band['where']}: {band['says']}" for band in law["bands"]], quantity


@pytest.mark.claim("report", "verdict-words")
@pytest.mark.parametrize(
    ("factor", "bands", "recommendation"),
    [
        (
            lambda v: 1.0,
            ["from 2 to 7 km/s: numerically to 1 %"],
            "use the law from 2 to 7 km/s: numerically to 1 % against the simulation.",
        ),
        (
            lambda v: 0.8 if v > 5e3 else 1.0,
            ["up to 5 km/s: numerically to 1 %", "from 6 km/s: under-predicts by 20 %"],
            "use the law up to 5 km/s: numerically to 1 % against the simulation; from 6 km/s it under-predicts by "
            "20 %.",
        ),
        (
            lambda v: 1.2 if v > 5e3 else 1.0,
            ["up to 5 km/s: numerically to 1 %", "from 6 km/s: over-predicts by 20 %"],
            "from 6 km/s it over-predicts by 20 %.",
        ),
        (
            lambda v: 1.3 if v == 4e3 else 1.0,
            ["up to 3 km/s: numerically to 1 %", "at 4 km/s: over-predicts by 30 %", "from 5 km/s: numerically to 1 %"],
            "use the law up to 3 km/s: numerically to 1 %, from 5 km/s: numerically to 1 %, each against the "
            "simulation; at 4 km/s it over-predicts by 30 %.",
        ),
        (
            lambda v: 1.05,
            ["from 2 to 7 km/s: within 5 % (beyond the joint uncertainty)"],
            "from 2 to 7 km/s: within 5 % (beyond the joint uncertainty)",
        ),
        (
            lambda v: 1.05 if v < 2.5e3 else 1.0,
            ["from 2 to 7 km/s: within 5 % (beyond the joint uncertainty at 1 of 6 points)"],
            "within 5 %",
        ),
    ],
    ids=["exact", "low above 5 km/s", "high above 5 km/s", "high at 4 km/s", "5 % high", "5 % high at 2 km/s"],
)
def test_law_of_known_difference__gets_its_words(
    factor: Callable[[float], float], bands: list[str], recommendation: str
) -> None:
    """A law whose difference from the simulation is known gets the right words: exact, low or high, or within so much.

    A law off by more than its uncertainty is within so much at best; a contradicted point divides bands.
    """
    words, quantity = stated(factor)
    assert words == [each.replace(" %", "\u202f%") for each in bands]
    assert recommendation.replace(" %", "\u202f%") in quantity["recommendation"]
    if len({factor(speed) for speed in fakes.SPEEDS}) == 1:
        assert ("numerically" in json.dumps(quantity)) == ("numerically" in bands[0])


@pytest.mark.claim("report", "verdict-words")
def test_single_point__is_called_one() -> None:
    """One point, and a law without a stated range, are called that."""
    words, quantity = stated(lambda v: 1.0, speeds=(5e3,))
    assert words == ["at 5 km/s: numerically to 1\u202f%"]
    assert "(a single point)" in quantity["recommendation"]
    assert "At the one judged point no difference" in " ".join(quantity["laws"][0]["details"])
    document = document_of(lambda v: 1.0, rangeless=True)
    assert f"use the law ({NO_RANGE}) from" in document["verdict"]["quantities"][0]["recommendation"]
    assert "inside its" not in document["residuals"][0]["sentence"]


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
    """Where every run failed or is flagged, no law is judged, and the summary begins with that."""
    document = document_of(lambda v: 1.0, change=lambda result: replace(result, **changes))
    (quantity,) = document["verdict"]["quantities"]
    (band,) = quantity["laws"][0]["bands"]
    assert f"{band['where']}: {band['says']}" == f"from 2 to 7 km/s: not judged: {why}"
    assert document["verdict"]["summary"][0] == f"No recommendation for hole diameter (not judged: {why})."
    assert ("Under resolved: 6 of 6 points" in " ".join(quantity["flags"])) == ("flags" in changes)


@pytest.mark.claim("report", "verdict-words")
def test_residuals_of_mixed_sign__have_a_trend_and_no_average() -> None:
    """Residuals of mixed sign have a trend with its interval, and no average anywhere in the report."""
    document = document_of(lambda v: 1.0 + (v - 4500.0) / 5e4)
    (quantity,), (residual,) = document["verdict"]["quantities"], document["residuals"]
    (law,) = quantity["laws"]
    (band,) = law["bands"]
    assert band["says"] == "within 5\u202f% (beyond the joint uncertainty)"
    assert "no average is given; linear trend over 6 points: +2.0 ±" in law["details"][0]
    assert law["average"] is residual["everywhere"]["bias"] is residual["everywhere"]["relative_bias"] is None
    assert "on average" not in residual["sentence"].lower()


@pytest.mark.claim("report", "verdict-words")
def test_mixed_versions_of_a_measurement__judge_nothing() -> None:
    """Runs whose measurement mixes versions of its definition get no verdict."""
    versions = iter(range(100))

    def versioned(result: RunResult) -> RunResult:
        return fakes.of_version(result, NAME, 1 + next(versions) % 2)

    verdict = document_of(lambda v: 1.0, change=versioned)["verdict"]
    assert "by versions 1 and 2 of its definition" in verdict["reason"]
    assert not verdict["quantities"]


# ---- from cube.nc alone --------------------------------------------------------------------------

# A law whose residuals change sign along the speed and rise with it.
TILTED = fakes.law(
    "tilted", NAME, lambda shot, _: (0.8 + 0.05 * shot.speed / 1e3) * fakes.HOLE_LAWS[1].ratio(shot, ""), title="tilted"
)
# The run of a point that its numbers without a converged value are of.
FINEST = {"cells_per_diameter": -1, "offset": 0}
# What the judgement rests on, and what error bars hold: counted by hand from the invented runs.
SENTENCES = {
    "holes": (
        "Rests on numerics and on a model part that was measured at other speeds or t/d for 12 of 15 points, up to a "
        "factor of 2 away; one mesh, whose error is unknown; 2 of 18 points flagged and not judged.",
        "The joint uncertainty holds position on the grid, growth at the end of the run, definition of the measure, "
        "material and model; not assessed: mesh error, published scatter of the laws.",
        "",
    ),
    "refined": (
        "Rests on numerics and on a model part that was measured at other speeds or t/d for 3 of 6 points, up to a "
        "factor of 2 away.",
        "The joint uncertainty holds mesh error (at 5 of 6 points), scatter over offsets, position on the grid, growth "
        "at the end of the run, definition of the measure, material and model; not assessed: published scatter of the "
        "laws.",
        "",
    ),
    "craters": (
        "Rests on numerics and on a model part that was measured at other speeds or t/d for 1 of 4 points, up to a "
        "factor of 1.2 away; one mesh, whose error is unknown.",
        "The joint uncertainty holds position on the grid, growth at the end of the run, material and model; not "
        "assessed: mesh error, definition of the measure, published scatter of the laws.",
        "No recommendation for crater diameter (no law).",
    ),
}
SWEEPS = {"holes": fakes.holes(), "refined": fakes.refined_holes(), "craters": fakes.craters()}


@pytest.mark.claim("report", "verdict-sentences")
@pytest.mark.parametrize("case", SWEEPS)
def test_verdict__is_that_of_cube_nc(case: str, tmp_path: Path) -> None:
    """Words, numbers and bands of each law in the verdict are recomputed from cube.nc with xarray and numpy alone."""
    sweep = SWEEPS[case]
    results = fakes.results(sweep) if case == "craters" else fakes.with_trouble(sweep)
    catalogue = fakes.catalogue(sweep.scenario)
    catalogue = replace(catalogue, laws=(*catalogue.laws, *([TILTED] if case == "holes" else [])))
    file = cube.write(cube.build(sweep, results, catalogue), tmp_path / "cube.nc")
    with xr.open_dataset(file) as dataset:
        verdict = compare(dataset).as_json()["verdict"]
        assert (verdict["rests"], verdict["bars"], verdict["without_recommendation"]) == SENTENCES[case]
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
            best = max(quantity["laws"], key=lambda law: law["close"])
            clauses = [f"{each['where']}: {each['says']}" for each in best["bands"] if each["word"] in CLOSE]
            places = [quantity["recommendation"].find(clause) for clause in clauses]
            assert -1 not in places
            assert places == sorted(places)
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
        elif says.startswith("not judged") and "error bars" not in says:
            assert not judged.any()
        else:
            assert judged.any()
            assert not (mask & ~frame.inside).any()
            percent = [float(each) for each in PERCENT.findall(says)[0] if each] if "%" in says else []
            if says.startswith(CLOSE):
                limit = max(float(sizes.max()), float(bar.fillna(0.0).max()))
                assert limit <= MOST
                assert percent == [max(1, math.ceil(round(100.0 * limit, 6)))]
                assert says.startswith(band["word"])
                assert (band["word"] == "numerically") == (not beyond and bool((tests != 0.0).all()))
                counted = re.search(r"beyond the joint uncertainty(?: at (\d+) of (\d+) points)?", says)
                assert bool(counted) == bool(beyond)
                if counted:
                    assert (int(counted[1] or beyond), int(counted[2] or judged.sum())) == (beyond, int(judged.sum()))
            elif says.startswith(("agrees within", "not judged: error bars")):
                assert ((sizes <= bar) & (bar > MOST) | ~judged).all()
            else:
                ends = [round(100.0 * float(end)) for end in (sizes.min(), sizes.max())]
                sign = -1.0 if says.startswith("under") else 1.0
                assert ((sign * residual > np.maximum(MOST, bar.fillna(0.0))) | ~judged).all()
                assert percent == (ends if ends[0] < ends[1] else ends[:1])
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
            words = re.search(r"of speed ([\d.]+) .+ against (\S+) in the law", text)
            assert words
            for key, said in zip(("value", "law"), words.groups(), strict=True):
                over, _, under = said.partition("/")
                expected = np.polyfit(np.log(flat["speed"]), np.log(flat[key]), 1)[0]
                assert float(over) / float(under or 1) == pytest.approx(expected, abs=0.00501)
        elif text.startswith("Inside"):
            counts = [int((np.abs(residual) <= flat["bar"])[flat["tests"]].sum()), int(flat["tests"].sum())]
            assert [int(each) for each in NUMBER.findall(text)[:2]] == counts
