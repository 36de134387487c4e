"""The material point method: particles carry matter, and a grid of nodes, new in each step, their momentum.

``step.py`` has the stages in their order; ``transfer.py`` and ``stencils.py`` are the way from particles to nodes and
back, with the functions of ``shapes/``.
"""
