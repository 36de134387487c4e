"""The command ``whipple shots``: measured shots on shields, with what became of the wall."""

import math
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from service.cli.commands import SHOTS, Commands
from service.cli.console import print_json, print_table, say
from service.cli.options import Json
from studies.answers.question import read_question
from studies.quantities.findings import refusal
from studies.shields.shield import ShotAtShield
from studies.shields.shots.table import filtered, nearest, published, read_filters, read_shots
from studies.sweeps.document import read_sweep_file, text_of

app = typer.Typer()
COMMANDS = Commands("shots", SHOTS, app)

OWN = "give a CSV file with a row a shot"
# Field, unit and heading of a shot in a list.
SHOWN = (
    *(("source", "", "source"), ("shot", "", "shot"), ("outcome", "", "wall"), ("speed", "km/s", "speed")),
    *(("obliquity", "deg", "angle"), ("projectile_diameter", "mm", "d"), ("bumper_thickness", "mm", "bumper")),
    *(("stand_off", "mm", "stand-off"), ("wall_thickness", "mm", "wall")),
    *(("projectile", "", "projectile"), ("bumper", "", "of bumper"), ("wall", "", "of wall")),
)
SIZES = {"mm": 1e-3, "km/s": 1e3, "deg": math.radians(1.0)}  # of the units in SI


@app.command()
def shots(
    where: Annotated[
        list[str] | None,
        typer.Option(metavar="FIELD=VALUE", help="For instance wall=AA2219, or speed='6 km/s to 7 km/s'."),
    ] = None,
    at: Annotated[Path | None, typer.Option(metavar="FILE", help="The shots nearest to the shield of a file.")] = None,
    own: Annotated[
        Path | None, typer.Option(metavar="FILE", help="A table of one's own (CSV) in place of those that ship.")
    ] = None,
    count: Annotated[int, typer.Option(min=1, help="Shots that are listed.")] = 20,
    as_json: Json = False,
) -> None:
    """List measured shots on Whipple shields, with what became of the wall: filtered, or nearest to a shield first."""
    table = published().shots if own is None else read_shots(text_of(own, "--own", OWN))
    chosen = filtered(table, *read_filters(where or []))
    if at is not None:
        chosen = tuple(near.shot for near in nearest(_one_shield(at), chosen, count))
    if as_json:
        print_json([asdict(shot) for shot in chosen[:count]])
        return
    failed = sum(shot.is_perforated for shot in chosen)
    say(f"{len(chosen)} of {len(table)} shots; the wall failed in {failed}")
    rows = ([_shown(getattr(shot, name), unit) for name, unit, _ in SHOWN] for shot in chosen[:count])
    print_table([f"{words} ({unit})" if unit else words for _, unit, words in SHOWN], rows)


def _shown(value: float | str, unit: str) -> str:
    """A field of a shot in the unit of its column."""
    return value if isinstance(value, str) else f"{value / SIZES[unit]:.4g}"


def _one_shield(at: Path) -> ShotAtShield:
    """The shot at the shield of a file; raises InvalidInput where it asks about something else."""
    question = read_question(read_sweep_file(at))
    shot = None if question.axes else question.shot(question.fixed)
    if not isinstance(shot, ShotAtShield):
        cure = "give bumper, stand_off and wall_thickness, and no list of values"
        raise refusal("--at", str(at), "one shot at a shield", cure)
    return shot
