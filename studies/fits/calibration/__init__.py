"""Calibration: Johnson-Cook constants of a material, with their uncertainty, from Taylor bars that were shot.

``shots`` reads the table, ``design`` says which bars are computed and over which ranges of the constants, ``emulator``
interpolates these runs, ``posterior`` samples the constants (``emcee``), ``prediction`` holds shots against them, also
those of a series that was left out, ``results`` writes files, ``picture`` draws, and ``strength_part`` carries draws of
the posterior on to holes and craters. Called by ``whipple calibrate``; docs/calibrate.md.
"""
