"""Fits: laws and surrogates out of a cube.

``measured`` reads points from a cube or a table of shots, ``fit`` finds the constants of a form of law and compares
``forms`` by least squares; ``fitted`` is the law that a fit is for the next sweep, and reads it there;
``surrogate`` interpolates the runs of a cube with its error, and ``indices`` says how much of the variance each axis
explains.
"""
