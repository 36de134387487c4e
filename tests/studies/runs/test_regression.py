"""The same identity gives the same numbers, or a version says that it no longer does."""

import json
import math
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from studies import scenarios
from studies.quantities.parameters import declared
from studies.runs.remeasure import definitions
from tests import samples
from tests.claims.marked import claimed
from tests.claims.rows import Row, equal
from tests.studies.runs.regression import ALL, CASES, FILE, RELATIVE, computed, run_of, stored

COMMAND = "python -m tests.studies.runs.regression"
CURE = f"write {FILE.name} anew by `{COMMAND}`, and say in the commit which numbers, why and by how much"
STORED = stored()


def differences(case: str, stored: dict[str, Any], got: dict[str, Any]) -> str:
    """What a case gives otherwise than it is stored, and what has to be raised; empty where nothing differs."""
    if stored["identity"] != got["identity"]:
        return (
            f"{case} is another run now, {got['identity']} in place of {stored['identity']}: a default of its "
            "scenario, or what its identity holds, has changed, and stored results are not found again. If that is "
            f"meant, {CURE}"
        )
    if moved := _moved(stored["state"], got["state"]):
        return (
            f"{case} gives another state under the same identity: {moved}. If that is meant, raise PHYSICS_VERSION in "
            f"solver/__init__.py and {CURE}; if not, find what moved it"
        )
    wrong = [
        f"{name} reads {moved} off the same state with the same version {stored['measurements'][name]['version']}: "
        f"raise the version of {name} in studies/measurements"
        for name, reading in got["measurements"].items()
        if name in stored["measurements"]
        if (moved := _moved(stored["measurements"][name], reading))
        and reading["version"] == stored["measurements"][name]["version"]
    ]
    return f"{case}: {'; '.join(wrong)}, and {CURE}" if wrong else ""


def _moved(stored: dict[str, Any], got: dict[str, Any]) -> str:
    """The quantities that differ, each with by how much."""
    return ", ".join(
        f"{name} {stored.get(name)} -> {got.get(name)}"
        for name in dict.fromkeys((*stored, *got))
        if not _same(stored.get(name), got.get(name))
    )


def _same(stored: Any, got: Any) -> bool:
    if isinstance(stored, float) and isinstance(got, float):
        return math.isclose(stored, got, rel_tol=RELATIVE)
    return bool(stored == got)


# The sets of laws and shapes of these are compiled for nobody else, or they take seconds: 0.5 to 6 s (2026-11). The
# other cases have each method, and each scenario but plugging.
LONG = {
    *("thin plate, thesis, quarter", "thin plate, cubic form", "thin plate, GIMP"),
    *("thin plate, Steinberg-Guinan", "thick plate, perfectly plastic", "Taylor bar, quarter"),
}.union(*samples.offered("LONG"))


@pytest.mark.parametrize("case", claimed(CASES, CASES.keys() - LONG, "mend-again", "regression"))
def test_regression__same_identity_gives_the_same_numbers(case: str, tmp_path: Path) -> None:
    """The same identity gives the same numbers, also where that takes seconds."""
    assert case in STORED, f"{case} has no numbers: {CURE}"
    text = differences(case, STORED[case], json.loads(json.dumps(computed(case, tmp_path))))
    assert not text, text


def test_regression__numbers_belong_to_today_s_versions() -> None:
    assert set(STORED) == set(ALL), CURE
    for case in CASES:
        versions = {name: one["version"] for name, one in STORED[case]["measurements"].items()}
        run = run_of(case)
        measured = scenarios.load(run.scenario).measured_in(run.parameters)
        assert versions == {name: definitions(run.scenario)[name] for name in measured}, f"{case}: {CURE}"


def test_regression__has_a_case_of_every_scenario_and_method() -> None:
    wanted = set()
    for name in scenarios.names():
        method = declared(scenarios.load(name).parameters).get("method")
        wanted |= {(name, each) for each in (method.choices if method else ("mpm",))}
    runs = [run_of(case) for case in CASES]
    assert wanted == {(run.scenario, run.parameters.get("method", "mpm")) for run in runs}


def test_regression__has_a_value_of_every_measurement() -> None:
    cases = STORED.values()
    readings = [item for each in cases for item in each["measurements"].items()]
    valued = {name for name, reading in readings if reading["value"] is not None}
    assert {name for name, _ in readings} - valued == set().union(*samples.offered("OF_LONGER_RUNS"))


ROOT = Path(__file__).parents[3]
NUMBERS = "test_regression__same_identity_gives_the_same_numbers"
# What is changed: file, text, its replacement; the case that notices it, and the words in which it says so.
CHANGES: tuple[tuple[str, str, str, str, str], ...] = (
    (
        "studies/plate_impacts/plates.py",
        "OUTER = 0.2",
        "OUTER = 0.3",
        "plate impact",
        "raise the version of plateau_pressure",
    ),
    ("studies/bars/taylor_bar.py", "] = HUGONIOT", '] = "cubic"', "Taylor bar", "raise PHYSICS_VERSION"),
    ("studies/bars/taylor_bar.py", "BarSpeed = 190.0", "BarSpeed = 200.0", "Taylor bar", "is another run now"),
    ("solver/steps/timestep.py", "GROWTH = 1.05", "GROWTH = 1.06", "plate impact", "raise PHYSICS_VERSION"),
)


@pytest.mark.claim("mend-again", "digests", minutes=2.0)
def test_change__of_one_constant_is_seen(compared: Callable[[Row], None], tmp_path: Path) -> None:
    """One changed constant of the solver, of a measurement or of a scenario fails, and says what to raise."""
    for part in ("solver", "studies", "tests", "pyproject.toml"):
        source = ROOT / part
        if source.is_dir():
            shutil.copytree(source, tmp_path / part, ignore=shutil.ignore_patterns("__pycache__"))
        else:
            shutil.copy(source, tmp_path)
    whole = _outcome(tmp_path, *{change[3] for change in CHANGES})
    compared(equal("cases of the copy as it is that pass", expected=True, got="2 passed" in whole))
    for name, before, after, case, says in CHANGES:
        file = tmp_path / name
        text = file.read_text("utf-8")
        assert text.count(before) == 1
        file.write_text(text.replace(before, after), encoding="utf-8")
        output = _outcome(tmp_path, case)
        file.write_text(text, encoding="utf-8")
        found = says in output and "1 failed" in output
        compared(equal(f"{after} in {name}: {says}", expected=True, got=found))


def _outcome(folder: Path, *cases: str) -> str:
    """What pytest prints on the numbers of some cases, in a process of its own."""
    tests = [f"tests/studies/runs/test_regression.py::{NUMBERS}[{case}]" for case in cases]
    environment = {"PYTHONPATH": str(folder), "WHIPPLE_KERNEL_CACHE": str(folder / "kernels")}
    ended = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", *tests],
        cwd=folder,
        env={**os.environ, **environment, "PYTHONDONTWRITEBYTECODE": "1"},
        capture_output=True,
        text=True,
        check=False,
        timeout=600,
    )
    return ended.stdout + ended.stderr
