"""Cost of a particle-step of the tree at a path, in turns with a reference kernel: one JSON object on stdout.

``python tests/benchmarks/measure.py TREE [PROBLEM ...]``. A script and no module, so that trees of other versions can
be measured by the same text: it uses what all of them have. Figures are processor time; what counts is the ratio to
the reference, which has the same work on every version.
"""

import json
import statistics
import sys
import time
from pathlib import Path
from typing import Any

import numba
import numpy as np

WARM, PAIRS = 60, 7  # steps before, and pairs of blocks
BLOCK = 3e6  # particle-steps in a block, about

PROBLEMS: dict[str, dict[str, Any]] = {
    "axisymmetric_default": {"geometry": "axisymmetric", "cells_per_diameter": 32.0},
    "axisymmetric_linear": {
        "geometry": "axisymmetric",
        "cells_per_diameter": 32.0,
        "shape": "linear",
    },
    "axisymmetric_gimp": {"geometry": "axisymmetric", "cells_per_diameter": 32.0, "shape": "gimp"},
    "3d_linear": {"geometry": "quarter", "cells_per_diameter": 16.0, "recipe": "thesis"},
    "3d_gimp": {"geometry": "quarter", "cells_per_diameter": 10.0, "shape": "gimp"},
    "3d_spline": {"geometry": "quarter", "cells_per_diameter": 10.0},
}


@numba.njit
def reference(values: Any, turns: int) -> float:
    """Additions, multiplications, a square root and a division of each number in turn."""
    total = 0.0
    for _ in range(turns):
        for i in range(values.size):
            x = values[i]
            total += np.sqrt(x * x + 1.0) / (x + 2.0)
            values[i] = 0.5 * (x + total / (1.0 + abs(total)))
    return total


def simulation(name: str, threads: int = 1) -> Any:
    """A copper perforation at 4 km/s, warmed until the shock is inside."""
    from solver.simulation import start
    from studies.execution import setting_of
    from studies.materials import load
    from studies.run import resolve

    copper = load("copper-ofhc")
    given = {
        "speed": 4e3,
        "projectile_diameter": 8e-3,
        "plate_thickness": 2e-3,
        "projectile": "copper-ofhc",
        "target": "copper-ofhc",
        **PROBLEMS[name],
    }
    run = resolve("thin_plate", given, {"projectile": copper, "target": copper})
    made = start(setting_of(run).problem, threads=threads)
    for _ in range(WARM):
        made.advance()
    return made


def measured(name: str) -> dict[str, float]:
    """Nanoseconds of a particle-step and of a turn of the reference, and their ratio: medians over pairs."""
    made = simulation(name)
    steps = max(5, round(BLOCK / made.particles.mass.size))
    values = np.linspace(0.0, 1.0, 1 << 14)
    reference(values, 1)
    ours, theirs = [], []
    for _ in range(PAIRS):
        begin = time.process_time()
        done = 0
        for _ in range(steps):
            done += made.particles.mass.size
            made.advance()
        ours.append((time.process_time() - begin) / done * 1e9)
        begin = time.process_time()
        reference(values, 600)
        theirs.append((time.process_time() - begin) / 600 / values.size * 1e9)
    ratios = [one / other for one, other in zip(ours, theirs, strict=True)]
    return {
        "particles": made.particles.mass.size,
        "ns": statistics.median(ours),
        "reference_ns": statistics.median(theirs),
        "ratio": statistics.median(ratios),
    }


if __name__ == "__main__":
    tree, *names = sys.argv[1:]
    sys.path[:0] = [str(Path(tree).resolve())]
    print(json.dumps({name: measured(name) for name in names or PROBLEMS}))
