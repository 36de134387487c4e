"""Points: converged values over resolutions and offsets, in the cube and in what looks at it."""

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from studies.convergence.richardson import Sample, converge
from studies.cubes import cube
from studies.cubes.layout import MissingResult
from studies.cubes.variables import STATES, VERDICT_WORDS
from studies.reports import report
from studies.reports.compare import compare
from studies.reports.points import points_of, refined
from studies.reports.publish import publish_sweep
from tests.studies.support import compliance, fakes
from tests.studies.support.fakes import Axis, Sweep

SWEEP = fakes.refined_holes()
VERDICTS = {  # by the kind of error that the fakes have at each speed
    2e3: "converging",
    3e3: "converging",
    4e3: "oscillatory",
    5e3: "not in the asymptotic range",
    6e3: "not in the asymptotic range",
    7e3: "converging",
}
ZIP = Sweep(
    (Axis("speed", "m s-1", (5e3, 2e3)), Axis("plate_thickness", "m", (2e-3, 3e-3))),
    combine="zip",
    refinements=fakes.refinements(),
)


def built(sweep: Sweep = SWEEP, *shots: fakes.Observed, **replaced: Any) -> xr.Dataset:
    known = {**fakes.results(sweep), **replaced}
    return cube.build(sweep, known, fakes.catalogue(observations=shots))


def run_at(sweep: Sweep, **coordinates: float) -> fakes.Run:
    (found,) = [p.run for p in sweep.runs() if coordinates.items() <= p.coordinates.items()]
    return found


# --- the cube ---------------------------------------------------------------------------------------


def test_runs__keep_their_own_coordinates() -> None:
    dataset = built()
    assert dataset.hole_diameter.dims == ("speed", "cells_per_diameter", "offset")
    for point in SWEEP.runs():
        assert dataset.run_id.sel(point.coordinates).item() == point.run.id


def test_converged__lies_over_the_axes_that_a_user_asked_for() -> None:
    dataset = built()
    for name in ("", "_uncertainty", "_order", "_extrapolated", "_gci", "_verdict", "_reason"):
        assert dataset[f"hole_diameter_converged{name}"].dims == ("speed",)
    assert dataset.hole_diameter_by_law.dims == ("speed", "hole_diameter_law")


def test_converged__is_what_convergence_says_of_the_runs_of_a_point() -> None:
    dataset, results = built(), fakes.results(SWEEP)
    for speed, verdict in VERDICTS.items():
        runs = [p for p in SWEEP.runs() if p.coordinates["speed"] == speed]
        measured = [results[p.run.id].measurements["hole_diameter"] for p in runs]
        expected = converge(
            Sample(
                1 / p.coordinates["cells_per_diameter"],
                m.value,
                m.parts["resolution"],
                m.parts["growth"],
            )
            for p, m in zip(runs, measured, strict=True)
        )
        cell = dataset.sel(speed=speed)
        assert expected.verdict == verdict
        assert VERDICT_WORDS[int(cell.hole_diameter_converged_verdict)] == verdict.replace(" ", "_")
        assert float(cell.hole_diameter_converged) == pytest.approx(expected.value)
        assert float(cell.hole_diameter_converged_uncertainty) == pytest.approx(
            expected.uncertainty
        )
        for part in ("order", "extrapolated", "gci"):
            found = float(cell[f"hole_diameter_converged_{part}"])
            assert found == pytest.approx(getattr(expected, part), nan_ok=True)


def test_order__of_the_fakes_is_found() -> None:
    orders = built().hole_diameter_converged_order.sel(speed=[2e3, 3e3, 7e3])
    np.testing.assert_allclose(orders, [1.0, 2.0, 1.5], rtol=1e-6)


@pytest.mark.parametrize(
    ("cells", "offsets", "dims"),
    [
        ((16.0,), (0.0,), ("speed",)),
        ((16.0,), fakes.OFFSETS, ("speed", "offset")),
        ((16.0, 32.0), (0.0,), ("speed", "cells_per_diameter")),
    ],
)
def test_refinement__is_a_dimension_only_where_there_are_several(
    cells: tuple[float, ...], offsets: tuple[float, ...], dims: tuple[str, ...]
) -> None:
    dataset = built(fakes.refined_holes(cells, offsets))
    assert dataset.hole_diameter.dims == dims
    assert ("hole_diameter_converged" in dataset) == (len(dims) > 1)


def test_zip__is_refined_along_its_runs() -> None:
    dataset = built(ZIP)
    assert dataset.hole_diameter.dims == ("run", "cells_per_diameter", "offset")
    assert dataset.speed.dims == ("run",)
    assert list(dataset.speed.values) == [5e3, 2e3]
    assert dataset.hole_diameter_converged.dims == ("run",)
    for point in ZIP.runs():
        cell = dataset.isel(
            run=point.index[0], cells_per_diameter=point.index[1], offset=point.index[2]
        )
        assert cell.run_id.item() == point.run.id


def test_failed_run__leaves_its_point_with_the_others_and_says_so() -> None:
    lost = run_at(SWEEP, speed=2e3, cells_per_diameter=64.0, offset=fakes.OFFSETS[0])
    dataset = built(SWEEP, **{lost.id: MissingResult("crashed", "out of luck")})
    whole = built()
    cell = dataset.sel(speed=2e3)
    assert "1 of 3 offsets without a value" in cell.hole_diameter_converged_reason.item()
    assert np.isfinite(cell.hole_diameter_converged)
    assert np.isnan(cell.hole_diameter.sel(cells_per_diameter=64.0, offset=0.0))
    others = slice(3e3, None)
    xr.testing.assert_identical(
        dataset.hole_diameter_converged.sel(speed=others),
        whole.hole_diameter_converged.sel(speed=others),
    )


def test_value_of_a_failed_run__takes_no_part() -> None:
    lost = run_at(SWEEP, speed=2e3, cells_per_diameter=64.0, offset=fakes.OFFSETS[0])
    late = replace(fakes.result(lost), state="failed", reason="late")
    reason = built(SWEEP, **{lost.id: late}).hole_diameter_converged_reason.sel(speed=2e3).item()
    assert "1 of 3 offsets without a value" in reason


def test_nothing__is_a_verdict_too() -> None:
    dataset = cube.build(SWEEP, {}, fakes.catalogue())
    assert (dataset.hole_diameter_converged_verdict == VERDICT_WORDS.index("no_value")).all()
    assert dataset.hole_diameter_converged_uncertainty.isnull().all()


@pytest.mark.parametrize(
    "sweep", [SWEEP, ZIP, fakes.refined_holes((16.0,))], ids=["grid", "zip", "offsets"]
)
def test_file__passes_the_cf_checker_and_reads_as_itself(tmp_path: Path, sweep: Sweep) -> None:
    dataset = built(sweep, *fakes.SHOTS)
    path = cube.write(dataset, tmp_path / "cube.nc")
    assert compliance.complaints(path) == []
    with xr.open_dataset(path) as read:
        cube.validate(read)
        for name, array in dataset.variables.items():
            np.testing.assert_array_equal(read[name].values, array.values)


def test_validate__knows_which_variables_are_over_points() -> None:
    dataset = built()
    spoilt = dataset.assign(hole_diameter_converged=dataset.hole_diameter)
    with pytest.raises(cube.SchemaError, match="hole_diameter_converged has the dimensions"):
        cube.validate(spoilt)


# --- points -----------------------------------------------------------------------------------------


def test_points__of_a_cube_without_refinement_are_its_runs() -> None:
    dataset = cube.build(fakes.holes(), fakes.results(fakes.holes()), fakes.catalogue())
    assert points_of(dataset) is dataset


def test_points__have_converged_values_and_error_bars() -> None:
    dataset = built()
    points = points_of(dataset)
    assert points.run_state.dims == ("speed",)
    np.testing.assert_array_equal(points.hole_diameter, dataset.hole_diameter_converged)
    np.testing.assert_array_equal(
        points.hole_diameter_uncertainty, dataset.hole_diameter_converged_uncertainty
    )


def test_points__succeed_where_any_run_gave_a_value() -> None:
    runs = [p.run for p in SWEEP.runs()]
    known = {
        run.id: MissingResult("cancelled", "enough") for run in runs[:9]
    }  # all of the first speed
    known[runs[-3].id] = MissingResult("crashed", "out of luck")  # one of the finest of the last
    points = points_of(built(SWEEP, **known))
    assert [STATES[state] for state in points.run_state.values[[0, -1]]] == [
        "cancelled",
        "succeeded",
    ]


def test_points__have_the_flags_of_their_finest_runs() -> None:
    coarse = run_at(SWEEP, speed=2e3, cells_per_diameter=16.0, offset=0.0)
    fine = run_at(SWEEP, speed=3e3, cells_per_diameter=64.0, offset=fakes.OFFSETS[1])
    known = {
        run.id: replace(fakes.result(run), flags=("under_resolved",)) for run in (coarse, fine)
    }
    flagged = points_of(built(SWEEP, **known)).run_flags != 0
    assert list(flagged.values[:3]) == [False, True, False]


def test_points_whose_finest_runs_failed__have_the_flags_of_those_their_value_is_of() -> None:
    known = {
        point.run.id: replace(
            fakes.result(point.run),
            **(
                {"state": "failed", "reason": "late"}
                if point.coordinates["cells_per_diameter"] == 64.0
                else {"flags": ("under_resolved",)}
            ),
        )
        for point in SWEEP.runs()
        if point.coordinates["speed"] == 2e3
    }
    points = points_of(built(SWEEP, **known))
    assert list((points.run_flags != 0).values[:2]) == [True, False]
    assert points.run_flags.attrs.keys() == built().run_flags.attrs.keys()


def test_flags_of_coarse_runs__stand_in_the_reason() -> None:
    coarse = run_at(SWEEP, speed=2e3, cells_per_diameter=16.0, offset=0.0)
    known = {coarse.id: replace(fakes.result(coarse), flags=("under_resolved",))}
    reason = str(built(SWEEP, **known).hole_diameter_converged_reason.sel(speed=2e3).item())
    assert "under resolved at the third of the resolutions that count" in reason


def test_finest_run_that_is_not_perforated__leaves_nothing_that_judges() -> None:
    finest = run_at(SWEEP, speed=2e3, cells_per_diameter=64.0, offset=0.0)
    held = replace(
        fakes.measured(0.01, "not_perforated"), value=None, uncertainty=None
    )  # as in fakes.with_trouble
    known = {finest.id: replace(fakes.result(finest), measurements={"hole_diameter": held})}
    dataset = built(SWEEP, **known)
    (point, *_) = refined(dataset, "hole_diameter")
    assert point.verdict == "not in the asymptotic range"
    assert math.isnan(point.mesh)
    assert math.isnan(point.extrapolated)
    (law,) = [one for one in compare(dataset).residuals if one.subject == "maiden_c"]
    assert (law.everywhere.n, law.everywhere.judged) == (6, 5)


def test_levels__read_from_the_cube_are_those_of_the_runs() -> None:
    dataset = built()
    for one, speed in zip(refined(dataset, "hole_diameter"), VERDICTS, strict=True):
        runs = dataset.hole_diameter.sel(speed=speed)
        assert [level.spacing for level in one.levels] == [1 / 64, 1 / 32, 1 / 16]
        means = runs.mean("offset").sel(cells_per_diameter=[64.0, 32.0, 16.0])
        np.testing.assert_allclose([level.value for level in one.levels], means.values)
        half = 0.5 * (runs.max("offset") - runs.min("offset")).sel(
            cells_per_diameter=[64.0, 32.0, 16.0]
        )
        np.testing.assert_allclose([level.scatter for level in one.levels], half.values)


# --- comparison and report --------------------------------------------------------------------------


def test_laws__are_compared_with_the_converged_value() -> None:
    dataset = built()
    answers = dataset.hole_diameter_by_law.sel(hole_diameter_law="maiden_c")
    (found,) = [one for one in compare(dataset).residuals if one.subject == "maiden_c"]
    difference = answers - dataset.hole_diameter_converged
    assert found.everywhere.n == 6
    assert found.everywhere.bias == pytest.approx(float(difference.mean()))
    inside = np.abs(difference) <= dataset.hole_diameter_converged_uncertainty
    assert (found.everywhere.judged, found.everywhere.within) == (6, int(inside.sum()))


def test_scatter_over_offsets__widens_the_error_bar_of_a_law() -> None:
    wide, narrow = (
        points_of(built(fakes.refined_holes(offsets=offsets))).hole_diameter_uncertainty.sel(
            speed=2e3
        )
        for offsets in (fakes.OFFSETS, (0.0, 0.25, 0.75))
    )
    dataset = built()
    scatter = dataset.hole_diameter_converged_uncertainty_offsets.sel(speed=2e3)
    assert float(scatter) > 0.0
    rest = math.hypot(
        float(dataset.hole_diameter_converged_uncertainty_mesh.sel(speed=2e3)),
        float(dataset.hole_diameter_converged_uncertainty_measurement.sel(speed=2e3)),
    )
    assert float(wide) == pytest.approx(math.hypot(rest, float(scatter)))
    assert float(wide) > rest
    assert float(narrow) != float(wide)


def test_sentence__says_how_far_the_simulation_is_converged() -> None:
    said = compare(built()).as_json()["residuals"]
    sentences = {one["subject"]: one["sentence"] for one in said}
    expected = "than the simulation (converged at 3 of 6 points); inside the error bar (median ±"
    assert expected in sentences["maiden_c"]
    assert "no point inside its stated range" in sentences["strength_ln/Y = 240 MPa"]
    (found,) = [one for one in said if one["subject"] == "maiden_al"]
    assert f"({found['in_range']['n']} of {found['everywhere']['n']} points)" in found["sentence"]


def test_sentence__names_the_converged_simulation_where_every_point_is() -> None:
    axes = (Axis("speed", "m s-1", (2e3, 3e3)), Axis("plate_thickness", "m", (2e-3,)))
    dataset = built(Sweep(axes, refinements=fakes.refinements()))
    said = compare(dataset).as_json()["residuals"]
    (found,) = [one["sentence"] for one in said if one["subject"] == "maiden_c"]
    assert "than the converged simulation; inside the error bar" in found


def test_observation__is_met_by_converged_values() -> None:
    dataset = built(SWEEP, fakes.observed(4e3, 2e-3, 15e-3))
    (sighting,) = compare(dataset).sightings
    assert sighting.how == "computed"
    assert sighting.simulation == float(dataset.hole_diameter_converged.sel(speed=4e3))


def test_simulation__is_judged_by_both_error_bars_together() -> None:
    dataset = built(SWEEP, fakes.observed(2e3, 2e-3, 11.2e-3, 0.3e-3))
    bar = math.hypot(0.3e-3, float(dataset.hole_diameter_converged_uncertainty.sel(speed=2e3)))
    (found,) = [one for one in compare(dataset).residuals if one.subject == "simulation"]
    assert found.everywhere.bar == pytest.approx(bar)
    assert 0.3e-3 < abs(found.everywhere.bias or 0.0) < bar
    assert found.everywhere.within == 1


def figure(said: dict[str, Any], name: str = "hole_diameter_convergence") -> dict[str, Any]:
    (found,) = [one for one in said["figures"] if one["name"] == name]
    return found


def said_of(dataset: xr.Dataset) -> dict[str, Any]:
    plain: dict[str, Any] = json.loads(report.as_json(report.document(dataset, compare(dataset))))
    return plain


def test_figure__shows_every_resolution_with_the_scatter_of_its_offsets() -> None:
    dataset = built()
    panels = figure(said_of(dataset))["panels"]
    assert [panel["at"]["speed"] for panel in panels] == list(VERDICTS)
    ratio = dataset.hole_diameter / fakes.DIAMETER
    for panel in panels:
        runs = ratio.sel(panel["at"])
        series = {one["kind"]: one for one in panel["series"]}
        assert series["level"]["x"] == [1 / 16, 1 / 32, 1 / 64]
        np.testing.assert_allclose(series["level"]["y"], runs.mean("offset").values)
        half = 0.5 * (runs.max("offset") - runs.min("offset")).values
        np.testing.assert_allclose(series["level"]["uncertainty"], half)
        assert sorted(series["run"]["y"]) == sorted(runs.values.ravel().tolist())


def test_figure__extrapolates_only_what_converges_and_says_the_verdict() -> None:
    dataset = built()
    for panel, verdict in zip(figure(said_of(dataset))["panels"], VERDICTS.values(), strict=True):
        kinds = {one["kind"]: one for one in panel["series"]}
        assert panel["note"].startswith(verdict)
        assert ("limit" in kinds) == ("trend" in kinds) == (verdict == "converging")
        cell = dataset.sel(panel["at"])
        if verdict == "converging":
            limit = float(cell.hole_diameter_converged_extrapolated) / fakes.DIAMETER
            assert (kinds["limit"]["x"], kinds["limit"]["y"]) == ([0.0], [limit])
            assert kinds["trend"]["y"][0] == pytest.approx(limit)
        value, bar = cell.hole_diameter_converged, cell.hole_diameter_converged_uncertainty
        assert kinds["band"]["low"][0] == pytest.approx(float(value - bar) / fakes.DIAMETER)
        assert kinds["band"]["high"][0] == pytest.approx(float(value + bar) / fakes.DIAMETER)


def test_figure__of_offsets_alone_is_not_drawn() -> None:
    said = said_of(built(fakes.refined_holes((16.0,))))
    assert not [one for one in said["figures"] if "convergence" in one["name"]]


def test_table__has_values_by_resolution_and_what_was_made_of_them() -> None:
    dataset = built()
    said = said_of(dataset)["convergence"]
    assert said["resolutions"] == list(fakes.CELLS)
    (holes,) = [one for one in said["quantities"] if one["quantity"] == "hole_diameter"]
    assert [row["verdict"] for row in holes["points"]] == list(VERDICTS.values())
    for row in holes["points"]:
        cell = dataset.sel(row["at"])
        assert row["value"] == float(cell.hole_diameter_converged)
        assert (row["extrapolated"] is None) == (row["verdict"] != "converging")
        means = cell.hole_diameter.mean("offset").values
        np.testing.assert_allclose([level["value"] for level in row["levels"]], means)


def test_report__without_refinement_says_that_the_mesh_was_not_asked_about() -> None:
    sweep = fakes.holes()
    said = said_of(cube.build(sweep, fakes.results(sweep), fakes.catalogue()))
    assert said["convergence"] is None
    assert "only several resolutions can say" in said["mesh"]


# --- cubes of the first schema ----------------------------------------------------------------------


def of_schema_1(dataset: xr.Dataset) -> xr.Dataset:
    """A cube as the first schema had it: no refinements, one dimension for all laws."""
    words = json.loads(dataset.attrs["vocabulary"])
    del words["refinements"], dataset.attrs["refinements"]
    dataset.attrs |= {"vocabulary": json.dumps(words), "schema_version": 1}
    for name in (
        "hole_diameter_by_law_at_observation",
        "hole_diameter_by_law_at_observation_in_range",
    ):
        answers = dataset[name]
        dims = ("observation", "hole_diameter_law")
        dataset = dataset.drop_vars(name).assign({name: (dims, answers.values, answers.attrs)})
    return dataset.drop_vars(["hole_diameter_observed_law", "hole_diameter_observed_law_title"])


def test_cube_of_the_first_schema__is_compared_and_reported_as_ever(tmp_path: Path) -> None:
    sweep = fakes.holes()
    new = cube.build(sweep, fakes.results(sweep), fakes.catalogue(observations=fakes.SHOTS))
    expected = said_of(new)
    path = cube.write(of_schema_1(new.copy()), tmp_path / "cube.nc")
    with xr.open_dataset(path) as read:
        said = said_of(read)
    assert said.pop("provenance")["schema_version"] == 1
    expected.pop("provenance")
    assert said == expected


# --- laws of other materials ------------------------------------------------------------------------


def test_shot_of_another_material__adds_no_constants_to_the_laws_of_the_runs() -> None:
    class Yields(fakes.Law):
        def variants(self, shot: Any) -> tuple[str, ...]:
            return ("Y = 345 MPa",) if shot.speed == 4321.0 else ("Y = 90 MPa",)

    law = Yields("strength", "hole_diameter", lambda shot, variant: 2.0)
    shot = fakes.observed(4321.0, 2e-3, 15e-3)
    sweep = fakes.holes()
    catalogue = replace(fakes.catalogue(observations=(shot,)), laws=(law,))
    dataset = cube.build(sweep, fakes.results(sweep), catalogue)
    assert list(dataset.hole_diameter_law.values) == ["strength/Y = 90 MPa"]
    assert (dataset.hole_diameter_by_law_reason == "").all()
    assert list(dataset.hole_diameter_observed_law.values) == ["strength/Y = 345 MPa"]
    residuals = compare(dataset).residuals
    assert [(one.subject, one.reference) for one in residuals] == [
        ("strength/Y = 90 MPa", "simulation"),
        ("simulation", "observation"),
        ("strength/Y = 345 MPa", "observation"),
    ]


def test_publish__writes_the_three_files_of_a_refined_sweep(tmp_path: Path) -> None:
    files = publish_sweep(SWEEP, fakes.results(SWEEP), tmp_path, fakes.catalogue())
    said = json.loads(Path(files["report.json"]).read_text(encoding="utf-8"))
    assert len(said["runs"]) == 54
    assert [axis["name"] for axis in said["coordinates"]] == [
        "speed",
        "cells_per_diameter",
        "offset",
    ]
