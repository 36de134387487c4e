"""Convergence of a measured number under refinement: ``richardson`` judges a series of grids, ``orders`` has its order.

Pure numbers in, pure numbers out; the cubes call it for each point and the reports show it.
"""
