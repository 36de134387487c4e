"""One file adds one thing: a distribution with one member of each kind, used in a sweep."""

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("studies.cases", reason="one of the kinds is a validation case")

ROOT = Path(__file__).parents[2]
ADDED = Path(__file__).parent / "added"

# A row of CONTRIBUTING's table: kind of thing, folder, how its files end, and the name that each offers.
ROW = re.compile(r"^\| ([\w ]+) \| `((?:solver|studies)/[\w/]+)/<name>\.(py|toml)` \| (?:`(\w+)`)?", re.M)
FILES = {
    "shape functions": "shape",
    "rule of tension": "tension",
    "equation of state": "eos",
    "validation case": "published",
    "material": "alloy",
}

# Each added model, on two grid cells across the projectile, for a few steps.
SWEEP: dict[str, Any] = {
    "name": "added",
    "scenario": "small_plate",
    "fixed": {
        "speed": "3 km/s",
        "projectile_diameter": "8 mm",
        "plate_thickness": "4 mm",
        "plate_radius": "12 mm",
        "projectile": "alloy",
        "target": "alloy",
        "shape": "tent",
        "tension": "half",
        "failure": "tension-limit",
        "failure_tension": "2 GPa",
        "particles_per_cell": 1,
        "end_time": "1 us",
    },
    "axes": {"target.strength.Y": ["90 MPa", "120 MPa"], "target.eos.K": ["130 GPa", "140 GPa"]},
    "resolution": 2,
}


def identities() -> dict[str, str]:
    """The identity of a run of each scenario that ships, and of impacts with every failure and every contact."""
    from tests.contracts.test_scenarios import SMALL, asked

    failures: tuple[dict[str, Any], ...] = (
        {"failure": "plastic-strain", "failure_strain": 0.5},
        {"failure": "spall", "failure_time": 1e-6},
        {"tension": "unlimited", "shape": "gimp", "eos_form": "elastic"},
        {"contact": "bardenhagen", "friction": 0.1},
    )
    cases: list[tuple[str, dict[str, Any]]] = [(name, {}) for name in SMALL]
    cases += [(name, each) for name in ("thin_plate", "thick_plate") for each in failures]
    return {f"{name} {changes}": asked(name, **changes).id for name, changes in cases}


def use(folder: Path) -> dict[str, Any]:
    """Expand the sweep, compute it, make its cube, and compare the added case; figures as plain objects."""
    from studies.cases import validation
    from studies.cubes import cube
    from studies.materials import load
    from studies.runs.execution import execute
    from studies.runs.run import estimate
    from studies.runs.stages import setting_of
    from studies.sweeps.sweep import Sweep

    runs = [point.run for point in Sweep.parse(SWEEP).runs()]
    results = {run.id: execute(run, folder / run.id, threads=1) for run in runs}
    dataset = cube.build(Sweep.parse(SWEEP), results)
    problem = setting_of(runs[-1]).problem
    matter = problem.bodies[1].matter
    records = (problem.shape, matter.tension, matter.failure, matter.strength, matter.eos)
    return {
        "states": [result.state for result in results.values()],
        "records": [type(record).__name__ for record in records],
        "constants": [
            next(iter(matter.tension._asdict().values())),
            matter.failure._asdict()["tension"],
            matter.strength._asdict()["Y"],
            matter.eos._asdict()["K"],
        ],
        "identities": identities(),
        "seconds": estimate(runs[0]).core_seconds,
        "attached share": dataset.attached_share.values.tolist(),
        "law": dataset.hole_diameter_by_law.sel(hole_diameter_law="proportional").values.tolist(),
        "material": load("alloy").sound_speed,
        "published": [row.passed for row in validation.load("attached").rows("quick", {"added": dataset})],
    }


@pytest.fixture(scope="module")
def table() -> dict[str, tuple[str, str, str]]:
    """Folder, ending and offered name of each kind in CONTRIBUTING's table."""
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    return {kind: tuple(rest) for kind, *rest in ROW.findall(text)}


@pytest.fixture(scope="module")
def distribution(table: dict[str, tuple[str, str, str]], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder for the search path, with the added files and the entry points that the table asks for."""
    folder = tmp_path_factory.mktemp("distribution")
    shutil.copytree(ADDED, folder / "added")
    entries = []
    for kind, (place, ending, offered) in table.items():
        file = FILES.get(kind, kind)
        value = f"added.{file}:{offered}" if ending == "py" else "added"
        entries.append(f"[whipple.{place.replace('/', '.')}]\n{file} = {value}\n")
    about = folder / "added-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: added\nVersion: 1.0\n")
    (about / "entry_points.txt").write_text("\n".join(entries))
    return folder


@pytest.fixture(scope="module")
def used(distribution: Path) -> dict[str, Any]:
    """The figures of the sweep, computed in a process of its own without the compiler."""
    code = (
        "import json, pathlib, sys; from tests.contracts.test_adding import use; "
        "print(json.dumps(use(pathlib.Path(sys.argv[1]))))"
    )
    path = os.pathsep.join((str(ROOT), str(distribution)))
    answer = subprocess.run(
        [sys.executable, "-c", code, str(distribution / "runs")],
        cwd=ROOT,
        env={**os.environ, "NUMBA_DISABLE_JIT": "1", "PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=False,
        timeout=300,
    )
    assert answer.returncode == 0, answer.stderr
    return json.loads(answer.stdout.splitlines()[-1])


def test_table__names_every_registry_and_every_added_file(table: dict[str, tuple[str, str, str]]) -> None:
    files = {f"{FILES.get(kind, kind)}.{ending}" for kind, (_, ending, _) in table.items()}
    assert files == {file.name for file in ADDED.iterdir() if file.is_file()}
    models = {f"solver/matter/{name}" for name in ("tension", "failure", "strength", "eos")}
    assert {place for place, _, _ in table.values()} >= {"solver/grid/shapes", *models}


def test_sweep__computes_with_every_added_member_and_its_constants(used: dict[str, Any]) -> None:
    assert used["states"] == ["succeeded"] * 4
    assert used["records"] == ["Tent", "HalfTension", "TensionLimit", "PowerHardening", "Murnaghan"]
    assert used["constants"] == [1.9e9, 2e9, 120e6, 140e9]
    assert used["material"] == pytest.approx((140e9 / 8930.0) ** 0.5)
    assert used["seconds"] > 0.0
    assert used["attached share"] == [[1.0, 1.0], [1.0, 1.0]]
    assert used["law"] == [[pytest.approx(12e-3)] * 2] * 2


def test_case__is_found_by_its_name(used: dict[str, Any]) -> None:
    assert used["published"] == [True]


def test_identity__of_a_run_that_uses_no_added_member_is_that_of_before(used: dict[str, Any]) -> None:
    assert used["identities"] == identities()
