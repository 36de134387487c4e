"""Figures of a report in a notebook: ``cube.whipple``."""
