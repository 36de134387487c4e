"""The cube: the results of a sweep as labelled variables, and as one NetCDF-4 file with groups.

``variables`` and ``audit`` declare each variable once: name, dimensions, unit, meaning, the group of the file in which
it stands (``groups``), and how a record of a run, a law or a shot gives its value (``variable``). ``cells`` puts each
run in its place, ``catalogue`` offers laws, shots and materials, ``cube`` joins them and writes the file, ``opening``
opens it; ``reading`` has what all readers ask of it, and ``points`` one value for each of its points. Called by
``reports`` and by processes that publish; the API never imports it.
"""
