"""Numbers that runs of shields state about themselves."""

from functools import partial

from studies.cubes.audit import AuditNumber

_behind = partial(AuditNumber, after="discarded_mass_fraction")
AUDIT = (
    AuditNumber("cells_per_wall", "1", "grid cells through the wall of a shield", after="cells_per_thickness", place=1),
    AuditNumber(
        *(
            "cells_per_piece",
            "1",
            "grid cells of a wall across the median piece of debris by mass; fewer than three blur it",
        ),
        after="cells_per_thickness",
        place=2,
    ),
    _behind(
        "missed_mass_fraction",
        "1",
        "debris that flew past the grid of a shield's wall, over projectile and bumpers",
        share=True,
        place=1,
    ),
    _behind(
        "flight_angular_momentum_error",
        "1",
        "angular momentum about the normal of the plane of symmetry that debris of a half shield does not keep in its "
        "flights from sheet to sheet, over the sum of its absolute values",
        share=True,
        place=2,
    ),
    _behind("clock_ahead", "s", "by how much the clock of the stage of a shield's wall is ahead", shown=False, place=3),
)
