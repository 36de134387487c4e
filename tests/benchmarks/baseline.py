"""Measures the step before the vectorised one, commit dc548a6: ``python -m tests.benchmarks.baseline``.

Its tree is checked out from the repository's own history for as long. The figures go to ``baseline.json``, against
which ``make bench`` says how many times as fast a step is, by way of the reference kernel.
"""

import json
import os
import platform
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from tests.benchmarks.measure import SWEEP

COMMIT = "dc548a6"
FILE = Path(__file__).with_name("baseline.json")
MEASURE = Path(__file__).with_name("measure.py")
ROOT = Path(__file__).parents[2]
MEASURED = (  # axisymmetric ones are small, those in three dimensions are not
    "axisymmetric_default_12k",
    "axisymmetric_linear_12k",
    "axisymmetric_gimp_12k",
    "3d_linear_117k",
    "3d_gimp_117k",
    "3d_spline_117k",
)

# The former return to yield ends here; round-off of the trial stress is what it can at best.
TOLERANCE = ("RETURN_TOLERANCE = 1e-5", "RETURN_TOLERANCE = 1e-15")


class NoHistory(LookupError):
    """The repository's history does not reach back to the commit."""


def measured(tree: Path, what: str, *arguments: Any) -> Any:
    """What ``measure.py`` finds in a tree, in a process of its own."""
    command = [sys.executable, "-P", str(MEASURE), str(tree), what, *map(json.dumps, arguments)]
    answer = subprocess.run(command, cwd=tree, check=True, stdout=subprocess.PIPE, text=True)
    return json.loads(answer.stdout)


@contextmanager
def former_tree(*, tight: bool = False) -> Iterator[Path]:
    """The tree of the commit, for as long; ``tight``: its return to yield goes on to round-off. Raises NoHistory."""
    git = ["git", "-C", str(ROOT)]
    exists = subprocess.run([*git, "cat-file", "-e", COMMIT], check=False, capture_output=True)
    if exists.returncode:
        raise NoHistory(f"the history does not reach back to {COMMIT}: fetch it (git fetch --unshallow)")
    with tempfile.TemporaryDirectory() as folder:
        tree = Path(folder) / COMMIT
        add = [*git, "worktree", "add", "--quiet", "--detach", str(tree), COMMIT]
        subprocess.run(add, check=True)
        try:
            if tight:
                file = tree / "solver" / "stress.py"
                text = file.read_text()
                assert TOLERANCE[0] in text
                file.write_text(text.replace(*TOLERANCE))
            yield tree
        finally:
            subprocess.run([*git, "worktree", "remove", "--force", str(tree)], check=True)


def main() -> None:
    """Measure what the file does not hold yet, and write it after each figure: remove the file to measure anew."""
    figures: dict[str, Any] = json.loads(FILE.read_text()) if FILE.exists() else {"commit": COMMIT}
    with former_tree() as tree:
        for kind, what, cases in (
            ("figures", "steps", {name: ([name],) for name in MEASURED}),
            ("sweep", "converging", {f"{case[0]:g} m/s, {case[1]:g} cells": case for case in SWEEP}),
        ):
            stored = figures.setdefault(kind, {})
            for name, arguments in cases.items():
                if name not in stored:
                    answer = measured(tree, what, *arguments)
                    stored[name] = {**answer.get(name, answer), **machine()}
                    FILE.write_text(json.dumps(figures, indent=2) + "\n")


def machine() -> dict[str, Any]:
    """Date, processor, its cores, how many processes asked for them in the last minute, and the Python."""
    lines = Path("/proc/cpuinfo").read_text().splitlines()
    models = [line.split(":")[1].strip() for line in lines if line.startswith("model name")]
    return {
        "date": datetime.now(UTC).date().isoformat(),
        "processor": models[0],
        "cores": len(models),
        "load": round(os.getloadavg()[0], 1),
        "python": platform.python_version(),
    }


if __name__ == "__main__":
    main()
