"""``make bench``: what a step, a run, the demo and a sweep cost.

``python -m tests.benchmarks steps memory`` measures these parts alone: those that take long (steps, demo) want a quiet
machine. ``--json FILE`` keeps the figures flat, beside those of other parts that the file holds already.
"""

import argparse
import json
import os
import platform
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from tests.benchmarks.figures import PARTS


def main() -> None:
    """Measure what was asked for, print each figure as it comes, and keep it where a file is named."""
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks")
    parser.add_argument("parts", nargs="*", metavar="NAME", help=f"of {', '.join(PARTS)}; else all")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures there too")
    asked = parser.parse_args()
    if unknown := set(asked.parts) - set(PARTS):
        parser.error(f"no part is named {', '.join(sorted(unknown))}; there are {', '.join(PARTS)}")
    file: Path | None = asked.json
    about = machine()
    figures = {**(json.loads(file.read_text()) if file and file.exists() else {}), **about}
    print(", ".join(f"{name} {value}" for name, value in about.items()))
    for part in asked.parts or PARTS:
        print(f"{part}: {PARTS[part].__doc__}")
        for name, value in PARTS[part]():
            print(f"    {name:48} {value:14.6g}", flush=True)
            figures[name] = value
            if file:
                file.write_text(json.dumps(figures, indent=2) + "\n", encoding="utf-8")


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
