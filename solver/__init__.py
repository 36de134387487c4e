"""Physics by three methods, in floats and arrays only.

``grid/``, ``sph/`` and ``fem/`` compute steps, ``coupling.py`` those of the last two in one problem, and
``simulation.py`` is the loop. What they share lies below: ``steps/``, ``audit.py``, ``checkpoints.py``, ``problem/``
and ``matter/``.
"""

# Part of every run's identity. It grows by one when the same input gives other numbers; a regression test notices.
PHYSICS_VERSION = 10
