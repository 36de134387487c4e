"""A debris cloud beside the flash radiograph of one."""

from collections.abc import Callable

import numpy as np
import pytest

from docs.pages.debris_shots import material_of
from solver.simulation import simulate
from studies.debris.cloud import CloudView, exceeded, view
from studies.debris.setting import CloudSetting
from studies.quantities.parameters import Plain
from studies.runs.run import resolve
from tests.claims.rows import Row, at_least, at_most, reported

# Radiograph of Piekutowski's in a public collection of figures: a sphere of 9.53 mm behind a sheet of 2.2 mm, shot
# 4-1351 or 4-1352, 6.6 km/s. Measured on it, by the size of the sphere, m. Neither its time nor the areal mass that
# makes an edge is stated: the front gives the time, and an edge lies where little of the mass is left.
FRONT, WIDTH, LIPS = 45.8e-3, 42.3e-3, 20.8e-3
SHOT: dict[str, Plain] = {
    **{"projectile": "al-2017-t4", "target": "al-6061-t6", "projectile_diameter": 9.53e-3, "plate_thickness": 2.2e-3},
    **{"speed": 6.6e3, "cells_per_diameter": 48, "failure": "void-growth"},
}
SHARES = (0.1, 0.01, 0.001)  # of the mass, which lie farther out
ENOUGH = 1.5 * FRONT / 6.6e3  # s: the front is past that of the radiograph
RINGS = 8
HALVINGS = 50


def cloud_of(tension: str) -> CloudView:
    """The cloud once its front is past that of the radiograph."""
    materials = {role: material_of(str(SHOT[role])) for role in ("projectile", "target")}
    run = resolve("debris_cloud", {**SHOT, "tension": tension, "end_time": ENOUGH}, materials)
    setting = run.set_up.build(run.materials)
    assert isinstance(setting, CloudSetting)
    return view(setting, simulate(setting.problem).snapshot)


def seen(cloud: CloudView, share: float) -> tuple[float, np.ndarray]:
    """When the front, but for a share of the mass, was where the radiograph has it, s before the end, and radii then.

    Debris flies straight. The radii (n,), m, are those of what is behind the sheet.
    """
    behind = cloud.behind() & ~cloud.plate

    def front(lead: float) -> float:
        place = cloud.depth[behind] - cloud.thickness - cloud.axial_velocity[behind] * lead
        return exceeded(place, cloud.mass[behind], share, cloud.width)

    late, early = 0.0, ENOUGH
    for _ in range(HALVINGS):
        middle = 0.5 * (early + late)
        late, early = (late, middle) if front(middle) < FRONT else (middle, early)
    return late, np.abs(cloud.radius[behind] - cloud.transverse_velocity[behind] * late)


@pytest.mark.claim("debris", "radiograph", minutes=2.0)
def test_cloud__is_as_wide_as_on_a_radiograph(compared: Callable[[Row], None]) -> None:
    """The edge of a radiograph lies between the width of 90 % of a cloud and that of all of it, with either tension.

    On 24 cells all of it is 41 mm wide, and the front is there at the same time within 1 %.
    """
    for tension in ("recoverable", "opening"):
        cloud = cloud_of(tension)
        behind = cloud.behind() & ~cloud.plate
        mass = cloud.mass[behind]
        widths = {}
        for share in SHARES:
            lead, radius = seen(cloud, share)
            widths[share] = 2e3 * exceeded(radius, mass, share, cloud.width)
            where = f"{tension}, {100 * (1 - share):g} % of the mass"
            compared(reported(f"{where}: time at which its front is there (us)", 1e6 * (ENOUGH - lead)))
            compared(reported(f"{where}: width (mm)", widths[share]))
        compared(at_most(f"{tension}: width of 90 % (mm)", limit=1e3 * WIDTH, got=widths[SHARES[0]]))
        lead, radius = seen(cloud, SHARES[1])
        compared(at_least(f"{tension}: width of all (mm)", limit=1e3 * WIDTH, got=2e3 * float(radius.max())))
        lips = cloud.plate & ((cloud.depth < 0.0) | cloud.behind())
        compared(reported(f"{tension}: width with lips (mm), {1e3 * LIPS:g} measured", 2e3 * cloud.radius[lips].max()))
        edges = np.linspace(0.0, 0.5 * WIDTH, RINGS + 1)
        per_ring = np.histogram(radius, edges, weights=mass)[0] / (np.pi * np.diff(edges**2))
        for edge, areal in zip(edges[1:], per_ring, strict=True):
            compared(reported(f"{tension}: areal mass up to {1e3 * edge:.1f} mm (kg/m2)", areal))
