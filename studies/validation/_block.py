"""The copper block of Ma (2005), section 3.2: 80 x 80 x 40 mm, perfectly plastic, Table 3.2, cells of 1 mm."""

from typing import Any

from studies.validation import Level

CELL = 1e-3  # m, of the thesis
MESH = "cells of 1 mm"

FIXED = {
    "projectile": "copper-thesis-plastic",
    "target": "copper-thesis-plastic",
    "recipe": "thesis",
    "target_depth": "40 mm",
    "target_radius": "40 mm",
    "edges": "fixed",
    "thermal_softening": False,
    "tension": "unlimited",
    "stop": "end_time",
}
REFINED = (1.0, 2.0, 4.0)  # of the fine level, cells of the thesis over the cells


def craters(level: Level, diameter: float, end_time: str, **fixed: Any) -> dict[str, Any]:
    """Parameters and resolutions of a crater at a level: a body of revolution, or the thesis' half model."""
    cells = diameter / CELL
    return {
        "scenario": "thick_plate",
        "fixed": {
            **FIXED,
            "projectile_diameter": f"{1e3 * diameter:.12g} mm",
            "geometry": "half" if level == "thesis" else "axisymmetric",
            "end_time": end_time,
            **fixed,
        },
        "resolution": [finer * cells for finer in REFINED] if level == "fine" else cells,
    }
