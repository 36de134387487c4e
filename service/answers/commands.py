"""Answers of laws and shots without a run: ``whipple laws``."""

import inspect
from pathlib import Path
from typing import Annotated

import typer

from service.cli.commands import SHIPPED, Commands
from service.cli.console import print_json, print_table, say, value_with_unit
from service.cli.options import Json
from studies.answers import examples
from studies.answers.answer import ShotAnswer, answers, document, shot_in_words
from studies.answers.question import Question, as_shot, read_question, shot_parameters, single_parameters
from studies.answers.targets import targets
from studies.quantities.display import display_of
from studies.quantities.files import write_atomically, write_text
from studies.quantities.findings import refusal
from studies.quantities.parameters import Parameter
from studies.sweeps.document import read_sweep_file, read_yaml

app = typer.Typer()

FORMATS = (".html", ".svg", ".png", ".pdf")  # of one answer
# Options that are not called as their parameters are.
FLAGS = {"projectile_diameter": "--diameter", "projectile_length": "--length", "plate_thickness": "--thickness"}


def laws(
    at: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Ask every law about the shots of a file (YAML or JSON).")
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="Write the answer: .html, .svg, .png or .pdf, or laws.nc of many shots.")
    ] = None,
    as_json: Json = False,
    **asked: str | None,
) -> None:
    """Ask all published laws about a shot: --at FILE, or --speed, --projectile, ..."""
    given = {name: value for name, value in asked.items() if value is not None}
    if at is None and not given:
        raise refusal("laws", "no shot", "--at FILE, or --speed, ...", "name a shot; `whipple list laws` lists them")
    question = read_question({**(as_shot(read_sweep_file(at)) if at else {}), **given})
    if out is not None:
        say(f"written: {_write(question, out)}")
    elif as_json:
        print_json(document(question))
    else:
        for number, answer in enumerate(answers(question)):
            if number:
                say("")
            _show_answer(answer, [axis.name for axis in question.axes])


def _option(parameter: Parameter) -> inspect.Parameter:
    """A parameter of a shot as an option of the command."""
    flag = FLAGS.get(parameter.name, f"--{parameter.name.replace('_', '-')}")
    metavar = "MATERIAL" if parameter.kind == "material" else "QUANTITY"
    option = typer.Option(flag, metavar=metavar, help=f"{parameter.meaning.capitalize()}.")
    kind = inspect.Parameter.KEYWORD_ONLY
    return inspect.Parameter(parameter.name, kind, default=None, annotation=Annotated[str | None, option])


def _signature() -> inspect.Signature:
    """Of the command, with an option for each parameter of which a shot has one."""
    *own, _ = inspect.signature(laws).parameters.values()
    return inspect.Signature([*own, *map(_option, single_parameters().values())])


# Typer makes its options of the signature.
laws.__signature__ = _signature()  # type: ignore[attr-defined]  # as inspect.signature has it
app.command()(laws)


def _write(question: Question, out: Path) -> Path:
    """The answer as a file, by the ending of its name; raises InvalidInput."""
    if not out.parent.is_dir():
        raise refusal("--out", str(out), "a file in a folder that exists", f"create the folder {out.parent}")
    if out.suffix == ".nc":
        from studies.answers.cube import netcdf

        content = netcdf(question)
        return write_atomically(out, lambda file: file.write_bytes(content))
    if out.suffix not in FORMATS:
        raise refusal("--out", str(out), f"a name that ends in .nc, {', '.join(FORMATS)}", "write laws.html")
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


def _print_examples(folder: Path) -> None:
    """Print what laws and shots say about the questions that ship, and write their pages."""
    for example in examples():
        question = read_question(read_yaml(example.read_text(encoding="utf-8"), example.name))
        [answer] = answers(question)
        say(f"{shot_in_words(question.shot(question.fixed))}: {answer.headline()}", flush=True)
        _write(question, folder / f"{example.stem}.html")


COMMANDS = Commands("answering", SHIPPED, app, place=1, demo=_print_examples)


def _show_answer(answer: ShotAnswer, varied: list[str]) -> None:
    told = answer.addition.told if answer.addition else None
    if varied:
        values = ((name, answer.parameters[name], shot_parameters()[name].unit) for name in varied)
        said = (f"{name} {value_with_unit(value, unit)}" for name, value, unit in values)
        say(", ".join(said))
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
                *(said.law.name, said.printed(quantity.unit), "yes" if said.in_range else f"no: {said.outside}"),
                *(said.law.use, said.law.source),
            )
            for said in quantity.laws
            if not said.is_for_another_material
        )
        print_table(("law", "value", "in its range", "use", "source"), rows)
        if others := [said.law.name for said in quantity.laws if said.is_for_another_material]:
            say(f"for targets of another material: {', '.join(others)}")
    if answer.shots:
        say("\nPublished shots, nearest first")
        shots = [(near.shot, near.printed()) for near in answer.shots]
        measured = [(s.quantity.replace("_", " "), text, s.source, s.confidence, s.note) for s, text in shots]
        print_table(("measured", "value", "source", "confidence", "note"), measured)
    elif targets()[answer.target].table:
        say("\nNo published shot of these metals ships.")
