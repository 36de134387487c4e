"""Proven: exact answers, symmetries, robustness and convergence of the solver."""
