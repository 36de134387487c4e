"""Films of runs: written while a run is solved, read as a dataset over time and particle, exported to VTK.

``film`` is called by ``runs``; ``film_dataset`` and ``vtk`` by ``whipple.open_film`` and the exports of cubes and runs.
``section`` keeps a few sections of every run, and with those of debris a ``radiograph``: ``runs`` records them,
``reports`` draws them.
"""
