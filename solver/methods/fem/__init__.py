"""Finite elements: a mesh that moves with the matter, one state in each element.

The third method beside the grid (``solver/grid``) and the smoothed particles (``sph``): the same problem, laws
of matter, update of points, audit and checkpoints, with a ``Stepper`` of its own for bodies that have a ``Mesh``. The
particles of such a body are its nodes: they have mass, position and velocity, and show the mean of the elements around
them. Hexahedra in a box; lumped masses; central differences; one integration point with hourglass control. Nodes of
several bodies that begin at one place are joined and never part. Forces are the adjoint of the velocity gradient, so
that momentum and energy are kept to round-off.
"""
