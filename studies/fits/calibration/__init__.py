"""Calibration: Johnson-Cook constants of a material, with their uncertainty, from Taylor bars that were shot.

``shots`` reads the table, ``design`` says which bars are computed and over which ranges of the constants, ``emulator``
interpolates these runs, ``posterior`` samples the constants (``emcee``), ``prediction`` holds shots against them, also
those of a series that was left out, ``results`` writes files, and ``picture`` draws. A sweep with ``model_part:
screen`` carries draws on to holes and craters (``studies.sweeps.screening``). Called by ``whipple calibrate``;
docs/calibrate.md.
"""
