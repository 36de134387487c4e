"""The cube: the results of a sweep as one labelled xarray Dataset and one NetCDF-4 file.

``variables`` declares each variable once: name, dimensions, unit, meaning, and how a record of a run, a law or a shot
gives its value. ``cells`` puts each run in its place, ``catalogue`` offers laws, shots and materials, ``cube`` joins
them and writes the file; ``points`` reads one value for each point of it. Called by ``reports`` and by processes
that publish; the API never imports it.
"""
