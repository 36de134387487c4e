"""Figures of cubes as files: the command ``whipple plot``."""

import math
from functools import partial
from pathlib import Path
from typing import Annotated, Literal

import typer

from service.cli.commands import LOCAL, Commands
from service.cli.console import print_table
from service.cli.options import folder_of
from studies.quantities.display import printed_in, with_unit

app = typer.Typer()
COMMANDS = Commands("plots", LOCAL, app, place=1)


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
    from studies.plots.two_cubes import draw_two, two_cubes
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
