"""Numbers that runs of shields state about themselves."""

from studies.cubes.audit import AuditNumber

AUDIT = (
    AuditNumber("cells_per_wall", "1", "grid cells through the wall of a shield"),
    AuditNumber(
        "cells_per_piece",
        "1",
        "grid cells of a wall across the median piece of debris by mass; fewer than three blur it",
    ),
    AuditNumber(
        "missed_mass_fraction",
        "1",
        "debris that flew past the grid of a shield's wall, over projectile and bumpers",
        share=True,
    ),
    AuditNumber(
        "flight_angular_momentum_error",
        "1",
        "angular momentum about the normal of the plane of symmetry that debris of a half shield does not keep in its "
        "flights from sheet to sheet, over the sum of its absolute values",
        share=True,
    ),
    AuditNumber("clock_ahead", "s", "by how much the clock of the stage of a shield's wall is ahead", shown=False),
)
