"""Files that other programs show: figures of cubes, and films as moving pictures and for ParaView."""

import math
from functools import partial
from pathlib import Path
from typing import Annotated, Literal

import typer

from service.cli.commands import LOCAL, Commands
from service.cli.console import print_table
from service.cli.options import folder_of
from studies.quantities.display import printed_in, with_unit
from studies.quantities.findings import refusal
from studies.sweeps.document import no_such_file

app = typer.Typer()
COMMANDS = Commands("drawing", LOCAL, app, place=1)


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
    from studies.cubes.exports import export_csv, export_zarr
    from studies.cubes.reading import open_cube
    from studies.films.film_dataset import open_film
    from studies.reports.drawing.animation import animate
    from studies.runs.exports import export_vtk, files_of

    if not (vtk or movie or zarr or csv):
        cure = "name what is to be written, for example --vtk out"
        raise refusal("export", str(source), "--vtk, --movie, --zarr or --csv", cure)
    if not source.exists():
        raise no_such_file(source, example="give the film.npz of a run that kept its film, or its folder")
    written = [] if vtk is None else export_vtk(files_of(source), folder_of(vtk))
    if movie:
        written.append(animate(open_film(source), movie, field, fps))
    if zarr or csv:
        cube = open_cube(source)
        written += [export_zarr(cube, zarr)] if zarr else []
        written += [export_csv(cube, csv)] if csv else []
    print("open " + ", ".join(map(str, written)))


@app.command()
def plot(
    cube: Annotated[Path, typer.Argument(metavar="CUBE", help="cube.nc of a sweep, or its folder.")],
    other: Annotated[
        Path | None, typer.Argument(metavar="[CUBE]", help="Another cube, to be drawn beside the first.")
    ] = None,
    out: Annotated[Path, typer.Option(help="Folder for the files, one for each figure.")] = Path(),
    format: Annotated[
        Literal["png", "svg", "pdf"], typer.Option(case_sensitive=False, help="Format of the files.")
    ] = "png",
) -> None:
    """Draw the figures of the report of a cube into files; of two cubes, the main figure with both.

    Two cubes are compared at the points that both have, in a table that is also written, in SI, as differences.csv.
    """
    from studies.reports.publish import draw_figures

    draw = draw_figures if other is None else partial(_compared, other=other)
    print(*draw(cube, folder_of(out), format), sep="\n")


def _compared(cube: Path, folder: Path, format: str, *, other: Path) -> list[Path]:
    """Print the differences of two cubes, and draw both into files."""
    from studies.reports.drawing.two_cubes import draw_two, two_cubes
    from studies.reports.view import title_of

    both = two_cubes(cube, other)
    files = draw_two(both, folder, format)
    if both.others:
        print(f"fixed and not the same: {'; '.join(' / '.join(words) for words in both.others.values())}")
    dataset = both.views[0].dataset
    rows = []
    for difference in both.differences():
        values = [printed_in(value, difference.scale.unit) for value in difference.values]
        share, bars = (
            f"{value:{style}}" if math.isfinite(value) else ""
            for value, style in ((difference.relative, "+.1%"), (difference.in_bars, "+.1f"))
        )
        at = title_of(dataset, difference.at)
        rows.append((with_unit(difference.scale.label, difference.scale.unit), at, *values, share, bars))
    if rows:
        print_table(("quantity", "at", *both.names, "difference", "in error bars"), rows)
    else:
        print("no point with a value is in both")
    return files
