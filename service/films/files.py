"""Files that a child process makes of what a run kept: VTK, moving pictures, and what pages draw."""

import gzip
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from service.conversions.conversions import FileInputs, Maker, sources_of
from service.records.jobs import VIEWS
from studies.quantities.files import write_atomically

if TYPE_CHECKING:
    from studies.runs.run import RunSpec


def _vtk(inputs: FileInputs, file: Path) -> None:
    from studies.films.vtk import export_vtk
    from studies.quantities.files import zipped

    zipped(lambda folder: export_vtk(sources_of(inputs), folder), file)


def _film(inputs: FileInputs, file: Path) -> None:
    from studies.films.animation import animate
    from studies.films.film_dataset import open_film

    [film] = sources_of(inputs).values()
    animate(open_film(film), file, field=inputs["options"]["field"])


def _view(inputs: FileInputs, file: Path) -> None:
    _, view, _ = file.name.split(".")
    [source] = sources_of(inputs).values()
    write_atomically(file, lambda part: part.write_bytes(packed_view(view, source, inputs["options"]["run"])))


def packed_view(view: str, source: Path, run: "RunSpec") -> bytes:
    """A view of a run from one of its files, packed and compressed by gzip."""
    from studies.films import views
    from studies.films.packed import packed
    from studies.runs.run import Run

    return gzip.compress(packed(getattr(views, view)(Run.from_json(run), source)), 6, mtime=0)


MAKERS: Mapping[str, Maker] = {"vtk.zip": _vtk, "gif": _film, **{f"{view}.view": _view for view in VIEWS}}
