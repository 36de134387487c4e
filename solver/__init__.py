"""Physics: particles, grid, materials, step. Floats and arrays only."""

# Part of every run's identity. It grows by one when the same input gives other numbers; a regression test notices.
PHYSICS_VERSION = 9
