"""Results as files of other programs: films and final states for ParaView, cubes as Zarr and as a table.

Called by the command line, and by child processes of the service.
"""

import json
import tempfile
import zipfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from studies.quantities.files import FILM, RESULT, STATE, write_atomically, write_text
from studies.quantities.findings import MissingExtra, refusal

if TYPE_CHECKING:
    from xarray import Dataset


def files_of(run: Path) -> dict[str, Path]:
    """Film, final state and result of a run by their names: the file at a path, or those in a folder."""
    if not run.is_dir():
        name = STATE if run.name.endswith(STATE) else FILM
        return {name: run}
    return {name: run / name for name in (FILM, STATE, RESULT) if (run / name).is_file()}


def export_vtk(files: Mapping[str, Path], folder: Path) -> list[Path]:
    """Write the film and the final state of a run into a folder; the files to open.

    ``files`` are those of the run by their names; the bodies of a state have the names that its result says. Raises
    InvalidInput where there is neither film nor state.
    """
    from studies.films.film_dataset import open_film
    from studies.films.vtk import export_film, export_state
    from studies.runs.remeasure import load_state

    if not {FILM, STATE} & set(files):
        raise refusal("run", ", ".join(files) or "no file", f"a {FILM} or a {STATE}", "submit with keep: final or film")
    written = []
    if FILM in files:
        with open_film(files[FILM]) as film:
            written.append(export_film(film, folder))
    if STATE in files:
        histories = json.loads(files[RESULT].read_bytes()).get("histories", {}) if RESULT in files else {}
        written += export_state(load_state(files[STATE]), histories.get("bodies", []), folder)
    return written


def export_zarr(dataset: "Dataset", out: Path) -> Path:
    """Write a cube as a Zarr store: a folder, or one file where the name ends in ``.zip``. Raises MissingExtra.

    Zarr 2 with consolidated metadata, which every reader knows: strings are no part of the specification of Zarr 3 yet.
    """
    try:
        import zarr  # noqa: F401 # xarray would import it later
    except ImportError as error:
        raise MissingExtra(f"Zarr needs more libraries ({error}): pip install 'whipple[zarr]'") from None
    plain = dataset.load().drop_encoding()  # chunks and filters of NetCDF mean nothing here
    plain.attrs.pop("digest", None)  # of the file that it was read from
    if out.suffix == ".zip":
        return zipped(lambda folder: plain.to_zarr(folder, zarr_format=2, consolidated=True), out)
    plain.to_zarr(out, mode="w", zarr_format=2, consolidated=True)
    return out


def export_csv(dataset: "Dataset", out: Path) -> Path:
    """Write the runs of a cube as a table with every column."""
    from studies.cubes.runs_table import runs_csv

    return write_text(out, runs_csv(dataset, every_column=True))


def zipped(fill: Callable[[Path], object], file: Path) -> Path:
    """One ZIP file of the folder that ``fill`` writes, whose files are compressed already."""

    def write(part: Path) -> None:
        with tempfile.TemporaryDirectory(dir=file.parent, prefix=f".{file.name}.", suffix=".part") as name:
            folder = Path(name)
            fill(folder)
            with zipfile.ZipFile(part, "w", zipfile.ZIP_STORED) as archive:
                for each in sorted(filter(Path.is_file, folder.rglob("*"))):
                    archive.write(each, each.relative_to(folder))

    return write_atomically(file, write)
