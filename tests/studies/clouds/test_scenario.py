"""The debris cloud of Ma (2005), section 3.1.2: 3 mm of copper, 6.6 km/s, 9 us."""

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from studies import measurements
from studies.convergence.richardson import Sample, converge
from studies.quantities.measured import DEFINITION, Measured, numerical_parts
from studies.runs.execution import execute
from studies.runs.remeasure import load_state
from studies.runs.run import Run, resolve
from tests.claims.rows import Row, absolute, at_most, equal

GRIDS = (16.0, 32.0, 64.0)  # cells across the projectile: 6, 12 and 24 through the plate
SPEED, DIAMETER, THICKNESS = 6600.0, 8e-3, 3e-3
MOMENTUM = 15.80  # N s, of the whole projectile
PRINTED = 0.005  # N s: half of its last digit
CLOSED = 1e-6  # of the momentum
FASTEST = 1.1  # of the free surface's velocity 2 u_p; of like metals u_p is half of the impact speed


def asked(cells: float, **changes: float) -> Run:
    case = {"speed": SPEED, "projectile_diameter": DIAMETER, "plate_thickness": THICKNESS, "end_time": 9e-6}
    roles = dict.fromkeys(("projectile", "target"), "copper-ofhc")
    return resolve("debris_cloud", {**case, **roles, "cells_per_diameter": cells, **changes})


@pytest.mark.claim("clouds", "debris-cloud", minutes=10.0)
def test_debris_cloud__keeps_its_momentum_and_its_tip_is_no_faster_than_a_free_surface(
    compared: Callable[[Row], None], tmp_path: Path
) -> None:
    """Nothing behind 3 mm of copper leaves the grid by 9 us, its momentum is closed, its tip flies at most at 1.1 v."""
    results = []
    for cells in GRIDS:
        result, where = execute(asked(cells), tmp_path, threads=1), f"{cells:g} cells:"
        results.append(result.measurements)
        departed = load_state(tmp_path / "state.npz").departed
        behind = float(departed.mass[departed.position[:, 1] > THICKNESS].sum())
        compared(equal(f"{where} mass that left downrange", expected=0.0, got=2.0 * math.pi * behind))
        momentum = np.sum(result.histories["axial_momentum"], axis=0) - result.histories["axial_impulse"]
        momentum += np.sum(result.histories["departed_axial_momentum"], axis=0)
        text = f"{where} axial momentum at the touch (N s)"
        compared(absolute(text, expected=MOMENTUM, got=float(momentum[0]), within=PRINTED))
        error = float(np.abs(momentum / momentum[0] - 1.0).max())
        compared(at_most(f"{where} axial momentum at any time, relative error", limit=CLOSED, got=error))
        tip = result.measurements["tip_velocity_permille"].value or math.nan
        text = f"{where} velocity that 0.1 % of the mass exceeds, over 2 u_p"
        compared(at_most(text, limit=FASTEST, got=tip / SPEED))
    for name in results[0]:
        compared(on_grids(name, [each[name] for each in results]))


def on_grids(name: str, grids: list[Measured]) -> Row:
    """A measurement on the grids, converged with its error bar; reported."""
    kind = measurements.load(name)
    samples = []
    for cells, measured in zip(GRIDS, grids, strict=True):
        rest = (size for part, size in numerical_parts(measured.parts).items() if part != "resolution")
        value = math.nan if measured.value is None else measured.value
        samples.append(Sample(1.0 / cells, value, measured.parts.get("resolution", 0.0), math.hypot(*rest)))
    point = converge(samples)
    values = ", ".join(f"{sample.value:.4g}" for sample in samples)
    error = "" if math.isnan(point.uncertainty) else f" +- {point.uncertainty:.2g}"
    part = grids[-1].parts.get(DEFINITION)
    definition = "" if part is None else f", definition {part:.2g}"
    got = f"{values}; {point.value:.4g}{error} ({point.verdict}){definition}"
    return Row(f"{kind.title} ({kind.unit}) on {', '.join(map('{:g}'.format, GRIDS))} cells; converged", "", got, None)
