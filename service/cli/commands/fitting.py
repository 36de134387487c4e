"""Laws and surrogates out of the cube of a sweep; no service is needed."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from service.cli.commands.options import Json
from studies.values.errors import Finding, InvalidInput

if TYPE_CHECKING:
    from studies.fits.fit import Fit
    from studies.fits.measured import Measured

app = typer.Typer()

Quantity = Annotated[
    str | None, typer.Option(metavar="NAME", help="The measured quantity; by default every one.")
]
At = Annotated[
    list[str] | None,
    typer.Option(metavar="AXIS=VALUE", help="Only points with this value: target=copper-ofhc."),
]


@app.command()
def fit(
    source: Annotated[
        str,
        typer.Argument(
            metavar="CUBE",
            help="cube.nc of a sweep, or its folder; or shots: a CSV file, or a published table by name.",
        ),
    ],
    quantity: Quantity = None,
    form: Annotated[
        str | None, typer.Option(metavar="NAME", help="The form of law; by default every one.")
    ] = None,
    at: At = None,
    out: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Write the fit as a law that a sweep can name."),
    ] = None,
    name: Annotated[str, typer.Option(help="Name of that law.")] = "",
    as_json: Json = False,
) -> None:
    """Fit forms of laws to the points of a cube or to shots; compare them with each other and with published laws."""
    from service.cli.console import print_json
    from studies.fits.fit import as_json as plain
    from studies.fits.fit import fits_of, forms_of

    fitted = []
    for measured in _measured(source, quantity, at or []):
        forms = forms_of(measured.quantity)
        chosen = [each for each in forms if form in (None, each.name)]
        if chosen:
            fitted.append(fits_of(measured, chosen))
    if not fitted:
        _refuse_form(form)
    if out is not None:
        _write(fitted, out, name)
    if as_json:
        print_json([plain(fits) for fits in fitted])
        return
    for fits in fitted:
        _print_fits(fits)
    if out is not None:
        print(f"written: {out}")


def _refuse_form(form: str | None) -> None:
    from studies.laws._forms import FORMS
    from studies.values.nearest import nearest_cure

    cure = nearest_cure(form, FORMS)
    raise InvalidInput([Finding("--form", str(form), "a form of law for what was measured", cure)])


def _measured(source: str, quantity: str | None, at: list[str]) -> "list[Measured]":
    """The points of a cube or a table; raises InvalidInput."""
    from studies import observations
    from studies.fits.measured import of_cube, of_table, open_cube, quantities_of
    from studies.laws._forms import LENGTHS

    if source.endswith(".csv") or (source in observations.names() and not Path(source).exists()):
        every = list(of_table(source, LENGTHS))
    else:
        dataset = open_cube(Path(source))
        every = [of_cube(dataset, each) for each in quantities_of(dataset, LENGTHS)]
    chosen = [each for each in every if quantity in (None, each.quantity)]
    if not chosen:
        there = ", ".join(each.quantity for each in every) or "none that a law is about"
        raise InvalidInput(
            [Finding("--quantity", str(quantity), f"one that {source} has", f"it has: {there}")]
        )
    return [each.at(each.read_place(at)) for each in chosen]


def _write(fitted: "list[list[Fit]]", out: Path, name: str) -> None:
    """Write the only fit into a file; raises InvalidInput where there are several, or none."""
    done = [each for fits in fitted for each in fits if each.solution is not None]
    if len(done) != 1:
        there = ", ".join(f"{each.measured.quantity} {each.form.name}" for each in done) or "none"
        cure = "choose with --quantity and --form" if done else "see the reasons without --out"
        raise InvalidInput([Finding("--out", there, "one fit", cure)])
    law = done[0].law(name)
    out.write_text(
        json.dumps(law.document(), indent=1, ensure_ascii=False, allow_nan=False) + "\n", "utf-8"
    )


def _print_fits(fits: "list[Fit]") -> None:
    from service.cli.console import print_table
    from studies.fits.fit import compared, verdicts

    measured = fits[0].measured
    weights = "weighted by their uncertainties" if measured.errors is not None else "equal weights"
    left_out = f"; {measured.left_out} left out: no value, or a flag" if measured.left_out else ""
    words = measured.quantity.replace("_", " ")
    print(f"{words}: {len(measured.shots)} points, {weights}{left_out}\n  {measured.source}")
    differences = {
        each.form.name: size
        for ranked in compared(fits)
        if len(ranked.fits) > 1
        for each, size in zip(ranked.fits, ranked.differences, strict=True)
    }
    rows = []
    for each in fits:
        if each.solution is None:
            rows.append((each.form.name, each.form.equation, each.reason, "", "", ""))
            continue
        constants = ", ".join(
            f"{name} = {_short(value.value)} ({_short(value.low)} to {_short(value.high)})"
            for name, value in each.constants.items()
        )
        lengths = each.in_millimetres()
        sizes = ", ".join(f"{_short(value)}" for value in lengths.values()) if lengths else ""
        compares = each.form.name in differences
        difference = f"{differences[each.form.name]:.1f}" if compares else ""
        rows.append(
            (
                each.form.name,
                each.form.equation,
                constants,
                sizes,
                f"{1e3 * each.rms:.2f}",
                difference,
            )
        )
        for law in each.published:
            stated = zip(each.form.constants, law.constants, strict=True)
            texts = ", ".join(f"{name} = {_short(value)}" for name, value in stated)
            rows.append(("", f"  {law.title}", texts, "", "", ""))
    columns = ("form", "equation", "constants (95 %)", "in mm", "rms (mm)", "AICc - best")
    print_table(columns, rows)
    for sentence in verdicts(fits):
        print(f"  {sentence}")


def _short(value: float) -> str:
    return f"{value:.3g}"
