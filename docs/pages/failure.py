"""docs/failure.md: which failure is the default, by a rule that was written down before the runs.

``python -m docs.pages compute failure DIRECTORY`` computes what the directory does not have, and writes
docs/results/failure.json and, of each failure, why it is out: ``studies/sweeps/thrown_out.json``, which this page and
the model part of an uncertainty read.
"""

import json
import math
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from itertools import product
from multiprocessing import get_context
from pathlib import Path
from statistics import median
from typing import Any

from docs.pages import MADE, RESULTS, computed_once, keep, read_json, table
from solver import PHYSICS_VERSION
from studies import materials, measurements
from studies.cases.validation import plate_spall
from studies.quantities.display import display_of, printed_in
from studies.quantities.measured import ENERGY_DRIFT_LIMIT
from studies.quantities.numerical_defaults import NO_FAILURE
from studies.runs.run import resolve
from studies.runs.stages import setting_of
from studies.sweeps.screening import SOURCED_FAILURES as FAILURES
from studies.sweeps.screening import THROWN_OUT, thrown_out
from studies.sweeps.sweep import Sweep

STORED = RESULTS / "failure.json"
COMMAND = "python -m docs.pages compute failure"
WORKERS = 2

METALS = ("copper-ofhc", "al-6061-t6", "al-2024-t3", "al-7075-t6")
SPEEDS = (3e3, 5e3, 7e3)  # m/s
SPHERE = {"projectile_diameter": 8e-3, "projectile_shape": "sphere", "geometry": "axisymmetric"}
# Of each scenario: parameters, cells across the sphere on three grids, and the quantities that are followed.
TARGETS: Mapping[str, tuple[dict[str, Any], tuple[float, ...], tuple[str, ...]]] = {
    "thin_plate": ({"plate_thickness": 2e-3}, (16.0, 24.0, 36.0), ("hole_diameter",)),
    "debris_cloud": (
        {"plate_thickness": 2e-3},
        (16.0, 24.0, 36.0),
        ("tip_velocity_percent", "cloud_radius", "momentum_behind"),
    ),
    "thick_plate": ({"edges": "absorbing"}, (4.0, 6.0, 9.0), ("crater_depth", "crater_diameter")),
}
HOLE = "hole_diameter"
SMALL = 0.01  # a change to the finest grid that needs no smaller one than the change before
NEAR = 0.05  # shares of converging series that are nearer than this are alike
LOST_MASS = 1e-12
# The slowest published plate impact of each metal with constants, and cells in the flyer.
SHOTS, FLYER_CELLS, NEAR_ENOUGH = ("copper-ofhc-190", "al-6061-t6-1335"), 50.0, 0.1

TEXT = """A hydrocode without failure parts matter where cells open between its particles; one with failure breaks it by
a rule. The rule decides between the failures `none`, `spall-rate` (the spall strength of plate impacts at the strain
rate), `johnson-cook` (Johnson and Cook's damage), `johnson-cook-spall` (both) and `void-growth` (tension that is lost
as voids grow); it was written down before any run:

1. A failure is out if a run of it fails, if energy drifts by more than {drift:g} %, or if mass is lost.
2. It is out if it misses the pull-back velocity of the slowest [published plate impact](validation/plate-spall.md) on a
   metal by more than 10 %, by both sound speeds that the published strength may have been taken with.
3. Each quantity of each shot on three grids, each 1.5 times finer, is a series. It converges if every run has settled
   and the change to the finest grid is smaller than the one before, or below 1 %. The failure with the largest share
   of converging series is the default; of shares within 5 percentage points, the smallest median change to the finest
   grid decides.

Measured holes and craters decide nothing. Spheres of 8 mm hit plates of 2 mm and blocks of the same metal at 3, 5 and
7 km/s: {metals}.
"""


@dataclass(frozen=True)
class Series:
    """A quantity of a shot on three grids, coarse to fine."""

    metal: str
    speed: float
    failure: str
    quantity: str
    values: tuple[float, ...]  # NaN where a run has none
    settled: bool

    @property
    def change(self) -> float:
        """The relative change to the finest grid; NaN without values."""
        *_, before, last = self.values
        return abs(before / last - 1.0)

    @property
    def converges(self) -> bool:
        first, middle, last = self.values
        return self.settled and self.change < max(abs(first - middle) / abs(last), SMALL)


def compute(directory: Path | None = None) -> None:
    """Compute every run that a directory does not have, and write the results."""
    with tempfile.TemporaryDirectory() as temporary:
        folder = (directory or Path(temporary)).resolve()
        asked = [*product(TARGETS, METALS, SPEEDS, FAILURES, range(3))]
        # The longest first, so that both processes end together.
        asked.sort(key=lambda run: (run[0] != "thick_plate", -run[-1]))
        with ProcessPoolExecutor(WORKERS, mp_context=get_context("spawn")) as pool:
            rows = list(pool.map(_computed, asked, [folder] * len(asked)))
            signals = list(pool.map(_signal, product(SHOTS, FAILURES), [folder] * len(SHOTS) * len(FAILURES)))
    document = {
        "physics": PHYSICS_VERSION,
        "command": COMMAND,
        "runs": sorted(rows, key=json.dumps),
        "signals": signals,
    }
    keep(document, STORED)
    keep(judged(document), THROWN_OUT)


def _computed(asked: tuple[str, str, float, str, int], folder: Path) -> dict[str, Any]:
    scenario, metal, speed, failure, grid = asked
    fixed, cells, quantities = TARGETS[scenario]
    loaded = materials.load(metal)
    roles = {"projectile": loaded, "target": loaded}
    changes = {"speed": speed, "failure": failure, "cells_per_diameter": cells[grid]}
    run = resolve(scenario, {**SPHERE, **fixed, **dict.fromkeys(roles, metal), **changes}, roles)
    result = computed_once(run, folder / run.id)
    print(scenario, metal, f"{speed / 1e3:g} km/s", failure, f"{cells[grid]:.3g}", result.state, flush=True)
    measured = {name: result.measurements[name] for name in quantities if name in result.measurements}
    return {
        "scenario": scenario,
        "metal": metal,
        "speed": speed,
        "failure": failure,
        "grid": grid,
        "state": result.state,
        "flags": list(result.flags),
        "values": {name: each.value for name, each in measured.items()},
        "still_growing": [name for name, each in measured.items() if "still_growing" in each.flags],
        "energy_drift": result.numbers.get("largest_energy_drift"),
        "mass_error": result.numbers.get("mass_error"),
        "failed_particles": result.numbers.get("failed"),
    }


def _signal(asked: tuple[str, str], folder: Path) -> dict[str, Any]:
    """The pull-back of a published plate impact with a failure, beside those that its strength may mean.

    All end at the time that a spall layer takes to ring, which is later than the default of matter that never fails.
    """
    shot, failure = asked
    number = plate_spall.shots()[shot]
    (longest,) = Sweep.parse(plate_spall.document(number, (FLYER_CELLS,))).runs()
    document = plate_spall.document(number, (FLYER_CELLS,), failure)
    document["fixed"]["end_time"] = f"{setting_of(longest.run).problem.end_time} s"
    (point,) = Sweep.parse(document).runs()
    pull = computed_once(point.run, folder / point.run.id).measurements["pullback_velocity"]
    published = list(plate_spall.pullbacks(number).values())
    return {"shot": shot, "failure": failure, "pull_back": pull.value, "published": published}


# ---- judged --------------------------------------------------------------------------------------


def series_of(runs: Sequence[Mapping[str, Any]]) -> Iterator[Series]:
    """Every quantity of every shot."""
    at = {tuple(run[key] for key in ("scenario", "metal", "speed", "failure", "grid")): run for run in runs}
    for scenario, (_, _, quantities) in TARGETS.items():
        for metal, speed, failure, quantity in product(METALS, SPEEDS, FAILURES, quantities):
            grids = [at[scenario, metal, speed, failure, grid] for grid in range(3)]
            values = tuple(math.nan if (value := run["values"].get(quantity)) is None else value for run in grids)
            settled = all(quantity not in run["still_growing"] for run in grids)
            yield Series(metal, speed, failure, quantity, values, settled)


def out(runs: Sequence[Mapping[str, Any]]) -> list[str]:
    """Why runs exclude their failure, each reason once."""
    reasons = []
    for run in runs:
        if run["state"] != "succeeded":
            reasons.append(f"{run['metal']} at {run['speed'] / 1e3:g} km/s: {run['state']}")
        elif abs(run["energy_drift"]) > ENERGY_DRIFT_LIMIT:
            reasons.append(f"energy drifts by {100 * run['energy_drift']:.2g} %")
        elif abs(run["mass_error"]) > LOST_MASS:
            reasons.append("mass is lost")
    return list(dict.fromkeys(reasons))


def missed(signals: Sequence[Mapping[str, Any]]) -> list[str]:
    """Why the pull-back of shots excludes a failure."""
    reasons = []
    for each in signals:
        pull, published = each["pull_back"], each["published"]
        if pull is None:
            reasons.append(f"no pull-back in {each['shot']}")
        elif min(abs(pull / value - 1.0) for value in published) > NEAR_ENOUGH:
            low, high = sorted(published)
            reasons.append(f"{each['shot']}: {pull:.0f} m/s, published {low:.0f} or {high:.0f}")
    return reasons


def judged(document: Mapping[str, Any]) -> dict[str, Any]:
    """Why the first two points of the rule throw each failure out; empty where they do not."""
    reasons = {}
    for failure in FAILURES:
        runs, signals = ([each for each in document[key] if each["failure"] == failure] for key in ("runs", "signals"))
        reasons[failure] = "; ".join([*out(runs), *missed(signals)])
    return {"physics": document["physics"], "command": document["command"], "reasons": reasons}


def _share(series: Sequence[Series]) -> float:
    return sum(each.converges for each in series) / len(series)


def _changes(series: Sequence[Series]) -> list[float]:
    """The changes to the finest grid of those series that have values."""
    return [each.change for each in series if math.isfinite(each.change)]


def pages() -> dict[str, str]:
    """docs/failure.md."""
    if not STORED.exists():
        return {}
    document = read_json(STORED)
    runs = document["runs"]
    series = list(series_of(runs))
    kinds = list(dict.fromkeys(each.quantity for each in series))
    rows = []
    for failure in FAILURES:
        mine = [each for each in series if each.failure == failure]
        of_kind = [[each for each in mine if each.quantity == kind] for kind in kinds]
        changes = [_changes(several) for several in of_kind]
        rows.append(
            [
                f"`{failure}`",
                thrown_out().get(failure, "nothing"),
                f"{100 * _share(mine):.0f} %",
                f"{100 * median(_changes(mine)):.2g} %",
                *(f"{100 * median(each):.2g} ({100 * max(each):.2g}) %" for each in changes),
            ]
        )
    heads = ["failure", "out by", "series that converge", "median change", *map(_title, kinds)]
    parts = [
        "# Which failure is the default\n",
        MADE.format(source="`docs/results/failure.json`"),
        TEXT.format(drift=100 * ENERGY_DRIFT_LIMIT, metals=", ".join(METALS)),
        f"Recomputed by `{COMMAND}`; change of each quantity to the finest grid: median (largest).\n",
        table(heads, rows),
        _choice(series),
        "\nThe finest values:\n",
        *_values(series, kinds),
    ]
    return {"failure.md": "\n".join(parts)}


def _choice(series: Sequence[Series]) -> str:
    """What the rule chooses of the failures that are left, and how far it is from no failure."""
    left = [failure for failure in FAILURES if failure not in thrown_out()]
    if not left:
        return "\nEvery failure is out, so that the rule chooses none of them.\n"
    chosen = max(left, key=lambda name: _share([each for each in series if each.failure == name]))
    value = {(each.failure, each.metal, each.speed, each.quantity): each.values[-1] for each in series}
    apart = [
        abs(value[chosen, metal, speed, HOLE] / value[NO_FAILURE, metal, speed, HOLE] - 1.0)
        for metal, speed in product(METALS, SPEEDS)
    ]
    names, most = " and ".join(f"`{name}`" for name in left), f"{100 * max(apart):.1f} %"
    return (
        f"\nNothing excludes {names}, and the rule chooses `{chosen}`: plates, blocks and debris clouds on a grid have "
        "it by default where the target has its constants, and none elsewhere: other methods were not studied, and "
        "shields keep none, though [drawn shots](simulated-shields.md) speak for it. Faster impacts, which the rule "
        "does not ask, are in "
        "[plate-spall](validation/plate-spall.md) and [limits](limits.md). Holes with it and without differ by "
        f"{most} at most. The [model part](report.md#the-outcome-of-a-law) of each bar names the failures that are out "
        "and does not count them.\n"
    )


def _values(series: Sequence[Series], kinds: Sequence[str]) -> Iterator[str]:
    """A table of the values on the finest grid and the change from the grid before, for each quantity."""
    for kind in kinds:
        rows, unit = [], measurements.load(kind).unit
        for metal, speed in product(METALS, SPEEDS):
            cells = []
            for failure in FAILURES:
                key = (metal, speed, failure, kind)
                (each,) = [s for s in series if (s.metal, s.speed, s.failure, s.quantity) == key]
                mark = "" if each.converges else "*"
                value, change = (
                    f"{printed_in(each.values[-1], unit)} {display_of(unit).unit}",
                    f"{100 * each.change:.2g}",
                )
                cells.append(f"{value} ± {change} %{mark}" if math.isfinite(each.change) else "no value*")
            rows.append([metal, f"{speed / 1e3:g} km/s", *cells])
        yield table([_title(kind), "speed", *FAILURES], rows) + "\n"
    yield "\\* does not converge.\n"


def _title(quantity: str) -> str:
    return measurements.load(quantity).title.lower()
