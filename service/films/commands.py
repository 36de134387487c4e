"""Files that other programs show: films as moving pictures and for ParaView, cubes as Zarr and CSV."""

from pathlib import Path
from typing import Annotated

import typer

from service.cli.commands import LOCAL, Commands
from service.cli.options import folder_of
from studies.quantities.files import write_text
from studies.quantities.findings import refusal
from studies.sweeps.document import no_such_file

app = typer.Typer()
COMMANDS = Commands("films", LOCAL, app, place=1)


@app.command()
def export(
    source: Annotated[
        Path,
        typer.Argument(metavar="SOURCE", help="film.npz or state.npz of a run, cube.nc of a sweep, or their folder."),
    ],
    vtk: Annotated[
        Path | None, typer.Option(help="Folder for VTK files: film.pvd with a VTU file per frame, state.vtu.")
    ] = None,
    movie: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="The film as a moving picture: .gif, or .mp4 (ffmpeg, or the extra video)."),
    ] = None,
    field: Annotated[
        str, typer.Option(help="Its colours: speed, pressure, temperature, plastic_strain or damage.")
    ] = "speed",
    fps: Annotated[int, typer.Option(min=1, max=60, help="Its frames in a second.")] = 10,
    zarr: Annotated[
        Path | None, typer.Option(help="Zarr store of the cube: a folder, or a file NAME.zarr.zip.")
    ] = None,
    csv: Annotated[Path | None, typer.Option(help="Table of the runs of the cube, with every column.")] = None,
) -> None:
    """Convert film and final state of a run to VTK files or a moving picture, or a cube to Zarr and CSV."""
    from studies.cubes.exports import export_zarr, runs_csv
    from studies.cubes.opening import whole_cube
    from studies.films.animation import animate
    from studies.films.film_dataset import open_film
    from studies.films.vtk import export_vtk, files_of

    if not (vtk or movie or zarr or csv):
        cure = "name what is to be written, for example --vtk out"
        raise refusal("export", str(source), "--vtk, --movie, --zarr or --csv", cure)
    if not source.exists():
        raise no_such_file(source, example="give the film.npz of a run that kept its film, or its folder")
    written = [] if vtk is None else export_vtk(files_of(source), folder_of(vtk))
    if movie:
        written.append(animate(open_film(source), movie, field, fps))
    if zarr or csv:
        cube = whole_cube(source)
        written += [export_zarr(cube, zarr)] if zarr else []
        written += [write_text(csv, runs_csv(cube, every_column=True))] if csv else []
    print("open " + ", ".join(map(str, written)))
