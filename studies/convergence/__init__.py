"""Convergence of a measured number under refinement: ``richardson`` judges the grids of a point.

Pure numbers in, pure numbers out; the cubes call it for each point and the reports show it.
"""
