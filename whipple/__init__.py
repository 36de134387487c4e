"""The public face of whipple, for notebooks and scripts: what ``__all__`` names.

>>> import whipple
>>> folder = whipple.run_sweep("holes.yaml", "holes")  # doctest: +SKIP
>>> whipple.open_cube(folder).hole_diameter  # doctest: +SKIP

Nothing inside the project imports this module, and importing it loads nothing heavy.
"""

import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import urlsplit

from solver.registry import points
from studies.quantities.findings import InvalidInput

if TYPE_CHECKING:
    import xarray

    from service.client.client import Client
    from service.estimates.estimate import estimate
    from service.notebooks.folder import SweepFolder
    from studies.answers.cube import laws
    from studies.films.film_dataset import open_film
    from studies.notebooks.tables import materials
    from studies.shields.shots.frame import shots

    __version__: str

__all__ = [
    "Client",
    "InvalidInput",
    "estimate",
    "flag_words",
    "laws",
    "materials",
    "open_cube",
    "open_film",
    "run_sweep",
    "shots",
]

LOOPBACK = ("127.0.0.1", "::1", "localhost")


def run_sweep(
    document: Mapping[str, Any] | str | Path,
    out: str | Path,
    *,
    overwrite: bool = False,
    keep: str = "final",
    every_column: bool = False,
) -> "SweepFolder":
    """Compute a sweep on this machine, without a server, and return the folder with its results.

    The folder is a path that a notebook shows as a table; ``plot()`` draws the figures of its report, and ``film()``
    the film of a run.

    ``document`` is a mapping or the path of a YAML file. In a mapping, arrays and quantities of pint may stand for
    numbers with a unit: ``"axes": [("speed", np.linspace(2, 7, 11), "km/s")]``. Its ``observations`` may be the path of
    a table of shots, from the current folder or from that of the YAML file. The folder holds ``cube.nc``, ``runs.csv``,
    ``report.html``, ``appendix.html`` and ``report.json``; called again with the same folder, it resumes: values on the
    axes may have been added or removed. A folder that holds another sweep is refused, unless that
    is to be replaced (``overwrite``). ``keep`` selects the files kept for each run: ``numbers``, also the ``final``
    state, or also the ``film``, which is then in ``runs/RUN/film.npz``. ``runs.csv`` has the
    columns that a person reads, or ``every_column``. A bar shows the progress on a terminal and in a notebook.
    """
    from service.cli.local import run_sweep
    from service.cli.progress import watched_progress

    with watched_progress(Path(out).name) as show:
        computed = run_sweep(document, out, overwrite=overwrite, keep=keep, every_column=every_column, progress=show)
        return _folder_of(computed)


def _folder_of(computed: os.PathLike[str]) -> Any:
    """The folder of a sweep, which a notebook shows as a table where the feature for it is there."""
    for point in points("face").select(name="SweepFolder"):
        return point.load()(computed)
    return Path(computed)


def open_cube(path: str | Path) -> "xarray.DataTree":
    """Open the cube of a sweep: ``path`` is a ``cube.nc``, a folder that holds one, or its address.

    The root has axes and main quantities, and its groups the rest: ``cube["laws"]``, ``cube["runs"]`` and others.
    ``cube.whipple.sel(speed="6 km/s")`` selects with units, ``cube.whipple.to_dataframe()`` is a table, and
    ``cube.whipple.plot_laws()`` and ``cube.whipple.plot()`` draw the figures of its report.

    An address (``http://.../v1/sweeps/ID/cube.nc``) is read as it is looked at; that needs ``pip install
    'whipple[remote]'``. The key in ``WHIPPLE_API_KEY`` is sent to this machine and to ``WHIPPLE_SERVICE`` alone.
    Raises InvalidInput for anything but a cube, and for one of another layout.
    """
    for point in points("face").select(name="figures"):
        point.load()  # cube.whipple
    if str(path).startswith(("http://", "https://")):
        open_remote = _of_feature("open_remote")
        key, service = (os.environ.get(name, "") for name in ("WHIPPLE_API_KEY", "WHIPPLE_SERVICE"))
        is_own = str(path).startswith(f"{service.rstrip('/')}/") or urlsplit(str(path)).hostname in LOOPBACK
        return open_remote(str(path), {"Authorization": f"Bearer {key}"} if key and is_own else {})
    from studies.cubes.opening import open_tree

    return open_tree(Path(path))


def flag_words(flags: "xarray.DataArray") -> list[tuple[str, ...]]:
    """The quality flags of a cube in words, for each run: ``flag_words(cube.run_flags)``."""
    from studies.cubes.reading import flag_words

    return flag_words(flags)


def __getattr__(name: str) -> Any:
    """What features offer is imported when it is first asked for."""
    if name == "__version__":
        from service import version

        return version()
    if name in __all__:
        return _of_feature(name)
    raise AttributeError(f"module 'whipple' has no attribute {name!r}; it offers {__all__}")


def _of_feature(name: str) -> Any:
    """What a feature offers by the entry points ``whipple.face``; raises AttributeError where it was taken away."""
    for point in points("face").select(name=name):
        return point.load()
    raise AttributeError(f"the feature that offers {name!r} is not installed")


def __dir__() -> list[str]:
    return __all__
