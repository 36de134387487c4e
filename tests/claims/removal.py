"""Takes one feature away and tries what is left: ``make claims without-NAME``.

A copy of the tree loses the folders of the feature and of those that need it (``[tool.whipple.features]`` of
pyproject.toml), their tests, and their lines of entry points. The copy then lists what it has, computes a small sweep
with its report, starts the service, imports every test of solver and studies, and passes those that all features share.
"""

import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from tests.claims.remaining import STEPS
from tests.contracts.features import features

ROOT = Path(__file__).parents[2]
LEFT_OUT = shutil.ignore_patterns(".*", "__pycache__", "*.egg-info")
MADE = {"build", "demo", "demo-full", "data", "dist", "site"}  # at the top of a tree in which someone works
SHARED = (
    "tests/contracts/test_laws.py",
    "tests/contracts/test_measurements.py",
    "tests/studies/runs/test_regression.py",
    "tests/studies/scenarios/test_refusals.py",
    "tests/studies/sweeps/test_sweep.py",
)
ALL = ("tests/solver", "tests/contracts", "tests/studies")
MINUTES = 40.0  # after which a step has failed


@dataclass(frozen=True)
class Tried:
    """A step on what is left of the tree."""

    name: str
    passed: bool
    last: str  # line of what it printed


def taken_with(name: str) -> set[str]:
    """A feature, and all that need it."""
    taken, known = {name}, features()
    while more := {other for other in known if taken & {*known[other].needs}} - taken:
        taken |= more
    return taken


def remove(tree: Path, name: str) -> None:
    """Take a feature, and those that need it, from a copy of the tree."""
    packages = [package for taken in taken_with(name) for package in features()[taken].folders]
    for taken in taken_with(name):
        shutil.rmtree(tree / "tests" / "cases" / taken, ignore_errors=True)
    for package in packages:
        for folder in (tree / package.replace(".", "/"), tree / "tests" / package.replace(".", "/")):
            shutil.rmtree(folder, ignore_errors=True)
        module = Path(package.replace(".", "/"))
        for file in (module.with_suffix(".py"), "tests" / module.parent / f"test_{module.name}.py"):
            (tree / file).unlink(missing_ok=True)
    project = tree / "pyproject.toml"
    offered = re.compile(rf'^[\w"-]+ = "({"|".join(map(re.escape, packages))})(\.|:|").*\n', re.M)
    project.write_text(offered.sub("", project.read_text(encoding="utf-8")), encoding="utf-8")


def tried(tree: Path) -> Iterator[Tried]:
    """The steps, on a copy of the tree."""
    for step in STEPS:
        yield _step(tree, step, "tests.claims.remaining", step)
    yield _step(tree, "collected", "pytest", "-q", "--collect-only", *ALL)
    there = [test for test in SHARED if (tree / test).exists()]
    yield _step(tree, "tested", "pytest", "-q", "--tb=short", *there)


def _step(tree: Path, name: str, *module: str) -> Tried:
    command = [sys.executable, "-W", "ignore", "-m", *module]
    environment = {**os.environ, "PYTHONPATH": str(tree), "PYTHONDONTWRITEBYTECODE": "1"}
    ended = subprocess.run(
        command, cwd=tree, env=environment, capture_output=True, text=True, check=False, timeout=60.0 * MINUTES
    )
    printed = (ended.stdout.strip() or ended.stderr.strip()).splitlines() if not ended.returncode else []
    failed = [line for line in ended.stdout.splitlines() if line.startswith(("FAILED", "ERROR"))]
    last = "; ".join(failed) or "".join((printed or ended.stderr.strip().splitlines() or [""])[-1:])
    return Tried(name, not ended.returncode, last)


def without(name: str, report: Callable[[Tried], object]) -> None:
    """Report each step of a copy of the tree without a feature."""
    with tempfile.TemporaryDirectory(prefix=f"whipple-without-{name}-") as folder:
        tree = Path(folder) / "tree"
        shutil.copytree(ROOT, tree, ignore=lambda at, names: {*LEFT_OUT(at, names), *(MADE if at == str(ROOT) else ())})
        remove(tree, name)
        for step in tried(tree):
            report(step)
