"""Limits in a report: those of a search, residual velocities, and the ballistic limit of a shield."""
