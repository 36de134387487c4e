"""Smoothed particle hydrodynamics: each particle sums over its neighbours, and there is no grid.

The second method beside the grid of ``solver/grid/step.py``: the same problem, particles, laws of matter, audit and
checkpoints, with stages of its own (``step.py``) that ``Problem.smoothing`` asks for. Forces are the adjoint of the
velocity gradient, pair by pair, so that momentum and energy are kept to round-off: Bonet and Lok (1999), Comput.
Methods Appl. Mech. Eng. 180, 97.

Bodies meet in the sums: a neighbour of another body counts as one of the own body (natural contact, as in LS-DYNA and
Autodyn). They stick where they meet, and feel each other from two smoothing lengths on. Where ``Smoothing.stiffness``
says so, particles of different solids repel each other instead, without friction (``contact.py``).

Problems have one, two (plane strain) or three dimensions, as many as their geometry has axes with cells; mass and
energy are per area, or per length, of what is left out. There is no axisymmetric form: the smoothing function of a ring
is an elliptic integral, and the plane one with a hoop term loses its consistency at the axis, where impacts look.
"""
