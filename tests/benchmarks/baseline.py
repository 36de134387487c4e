"""Measures the step that the vectorised one replaced: ``python -m tests.benchmarks.baseline``, on a quiet machine.

Its tree, commit dc548a6, is checked out beside this one for as long; the figures go to ``baseline.json``, with which
``make bench`` says how many times as fast a step is.
"""

import json
import platform
import subprocess
import sys
import tempfile
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

COMMIT = "dc548a6"
FILE = Path(__file__).with_name("baseline.json")
MEASURE = Path(__file__).with_name("measure.py")
ROOT = Path(__file__).parents[2]


def cost_of(tree: Path, *names: str) -> dict[str, Any]:
    """The figures of a tree, measured in a process of its own."""
    command = [sys.executable, "-P", str(MEASURE), str(tree), *names]
    answer = subprocess.run(command, cwd=tree, check=True, capture_output=True, text=True)
    found: dict[str, Any] = json.loads(answer.stdout)
    return found


def main() -> None:
    """Check the old tree out, measure it, and write the file."""
    with tempfile.TemporaryDirectory() as folder:
        tree = Path(folder) / COMMIT
        git = ["git", "-C", str(ROOT), "worktree"]
        subprocess.run([*git, "add", "--quiet", "--detach", str(tree), COMMIT], check=True)
        try:
            figures = cost_of(tree)
        finally:
            subprocess.run([*git, "remove", "--force", str(tree)], check=True)
    about = {
        "commit": COMMIT,
        "date": datetime.now(UTC).date().isoformat(),
        "processor": _processor(),
        "python": platform.python_version(),
    }
    FILE.write_text(json.dumps({**about, "figures": figures}, indent=2) + "\n")


def _processor() -> str:
    lines = Path("/proc/cpuinfo").read_text().splitlines()
    return next(line.split(":")[1].strip() for line in lines if line.startswith("model name"))


if __name__ == "__main__":
    main()
