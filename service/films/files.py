"""Files that a child process makes of what a run kept: VTK, moving pictures, and what pages draw."""

from collections.abc import Mapping
from pathlib import Path

from service.conversions.conversions import FileInputs, Maker, sources_of
from service.records.jobs import VIEWS


def _vtk(inputs: FileInputs, file: Path) -> None:
    from studies.films.exports import export_vtk
    from studies.quantities.files import zipped

    zipped(lambda folder: export_vtk(sources_of(inputs), folder), file)


def _film(inputs: FileInputs, file: Path) -> None:
    from studies.films.animation import animate
    from studies.films.film_dataset import open_film

    [film] = sources_of(inputs).values()
    animate(open_film(film), file, field=inputs["options"]["field"])


def _view(inputs: FileInputs, file: Path) -> None:
    from studies.films import views
    from studies.films.packed import write
    from studies.runs.run import Run

    _, view, _ = file.name.split(".")
    [source] = sources_of(inputs).values()
    write(getattr(views, view)(Run.from_json(inputs["options"]["run"]), source), file)


MAKERS: Mapping[str, Maker] = {"vtk.zip": _vtk, "gif": _film, **{f"{view}.view": _view for view in VIEWS}}
