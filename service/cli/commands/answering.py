"""Answers of laws and shots without a run: ``whipple laws --at``, and the list of shots on shields."""

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from service.cli.commands import SHOTS, Commands
from service.cli.console import print_json, print_table, say
from service.cli.options import Json
from studies.quantities.display import display_of
from studies.quantities.files import write_atomically, write_text
from studies.quantities.findings import refusal
from studies.quantities.units import readable
from studies.sweeps.document import read_sweep_file, read_yaml, text_of

if TYPE_CHECKING:
    from studies.answers.answer import ShotAnswer
    from studies.answers.question import Question

app = typer.Typer()
COMMANDS = Commands("shots", SHOTS, app)

OWN = "give a CSV file with a row a shot"
FORMATS = (".html", ".svg", ".png", ".pdf")  # of one answer


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
    from dataclasses import asdict

    from studies.shields.shots import table as measured

    table = measured.published().shots if own is None else measured.read_shots(text_of(own, "--own", OWN))
    chosen = measured.filtered(table, *measured.read_filters(where or []))
    if at is not None:
        chosen = tuple(each.shot for each in measured.nearest(_one_shield(at), chosen, count))
    if as_json:
        print_json([asdict(each) for each in chosen[:count]])
        return
    failed = sum(each.is_perforated for each in chosen)
    say(f"{len(chosen)} of {len(table)} shots; the wall failed in {failed}")
    rows = ([_shown(getattr(each, name), unit) for name, unit, _ in _SHOWN] for each in chosen[:count])
    print_table([f"{words} ({unit})" if unit else words for _, unit, words in _SHOWN], rows)


# Field, unit and heading of a shot in a list.
_SHOWN = (
    *(("source", "", "source"), ("shot", "", "shot"), ("outcome", "", "wall"), ("speed", "km/s", "speed")),
    *(("obliquity", "deg", "angle"), ("projectile_diameter", "mm", "d"), ("bumper_thickness", "mm", "bumper")),
    *(("stand_off", "mm", "stand-off"), ("wall_thickness", "mm", "wall")),
    *(("projectile", "", "projectile"), ("bumper", "", "of bumper"), ("wall", "", "of wall")),
)


def _shown(value: Any, unit: str) -> str:
    """A field of a shot in the unit of its column."""
    sizes = {"mm": 1e-3, "km/s": 1e3, "deg": math.radians(1.0)}
    return f"{value / sizes[unit]:.4g}" if unit else str(value)


def _one_shield(at: Path) -> Any:
    """The shot at the shield of a file; raises InvalidInput where it asks about something else."""
    from studies.answers.question import read_question

    question = read_question(read_sweep_file(at))
    if question.target != "shield" or question.axes:
        raise refusal(
            "--at", str(at), "one shot at a shield", "give bumper, stand_off and wall_thickness, and no list of values"
        )
    return question.shot(question.fixed)


def print_answers(at: Path | None, given: dict[str, Any], out: Path | None, *, as_json: bool) -> None:
    """Ask every law about the shots of a file, with what the options change; raises InvalidInput."""
    from studies.answers.answer import answers, document
    from studies.answers.question import as_shot, read_question

    question = read_question({**(as_shot(read_sweep_file(at)) if at else {}), **given})
    if out is not None:
        say(f"written: {_write(question, out)}")
        return
    if as_json:
        print_json(document(question))
        return
    for number, answer in enumerate(answers(question)):
        if number:
            say("")
        _show_answer(answer, [axis.name for axis in question.axes])


def _write(question: "Question", out: Path) -> Path:
    """The answer as a file, by the ending of its name; raises InvalidInput."""
    from studies.answers.answer import answers

    if not out.parent.is_dir():
        raise refusal("--out", str(out), "a file in a folder that exists", f"create the folder {out.parent}")
    if out.suffix == ".nc":
        from studies.answers.cube import netcdf

        content = netcdf(question)
        return write_atomically(out, lambda file: file.write_bytes(content))
    if out.suffix not in FORMATS:
        raise refusal("--out", str(out), f"a name that ends in .nc, {', '.join(FORMATS)}", "write shield.html")
    if question.axes:
        cure = "write laws.nc, or give each parameter one value"
        raise refusal("--out", str(out), "a page or a picture of one shot", cure)
    from studies.answers.page import page
    from studies.answers.picture import picture
    from studies.reports.drawing.charts import draw

    [answer] = answers(question)
    shot = question.shot(question.fixed)
    if out.suffix == ".html":
        return write_text(out, page(answer, shot))
    return draw(picture(shot, answer.target), out)


def print_examples(folder: Path) -> None:
    """Print what laws and shots say about the questions that ship, and write their pages."""
    from studies.answers import examples
    from studies.answers.answer import answers, shot_in_words
    from studies.answers.question import read_question

    for example in examples():
        question = read_question(read_yaml(example.read_text(encoding="utf-8"), example.name))
        [answer] = answers(question)
        say(f"{shot_in_words(question.shot(question.fixed))}: {answer.headline()}", flush=True)
        _write(question, folder / f"{example.stem}.html")


def _show_answer(answer: "ShotAnswer", varied: list[str]) -> None:
    from studies.answers.question import shot_parameters
    from studies.answers.targets import targets

    target = targets()[answer.target]
    told = target.told(answer.addition) if answer.addition else None
    if varied:
        units = {name: each.unit for name, each in shot_parameters().items()}
        say(", ".join(f"{name} {_readable(answer.parameters[name], units[name])}" for name in varied))
    for line in told.lines if told else ():
        say(line)
    for quantity in answer.quantities:
        say(quantity.sentence())
    if told:
        say("")
        print_table(told.columns, told.rows)
    for quantity in answer.quantities:
        unit = display_of(quantity.unit)
        say(f"\n{quantity.title} ({unit.unit})")
        rows = (
            (
                *(each.law.name, each.printed(quantity.unit), "yes" if each.in_range else f"no: {each.outside}"),
                *(each.law.use, each.law.source),
            )
            for each in quantity.laws
            if not each.is_for_another_material
        )
        print_table(("law", "value", "in its range", "use", "source"), rows)
        if others := [each.law.name for each in quantity.laws if each.is_for_another_material]:
            say(f"for targets of another material: {', '.join(others)}")
    if answer.shots:
        say("\nPublished shots, nearest first")
        shots = [(near.shot, near.printed()) for near in answer.shots]
        measured = [(s.quantity.replace("_", " "), text, s.source, s.confidence, s.note) for s, text in shots]
        print_table(("measured", "value", "source", "confidence", "note"), measured)
    elif target.table:
        say("\nNo published shot of these metals ships.")


def _readable(value: Any, unit: str | None) -> str:
    return readable(value, unit) if unit else str(value)
