"""Runs that were still growing at their latest end, computed again: ``whipple continue``."""
