"""Laws and surrogates out of the cube of a sweep; no service is needed."""

import json
import sys
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from service.cli.commands import OUT_OF_A_CUBE, Commands
from service.cli.console import SHORT_ID, print_json, print_table
from service.cli.options import Json
from studies.quantities.display import display_of, with_unit
from studies.quantities.findings import nearest_cure, refusal

if TYPE_CHECKING:
    from studies.fits.fit import FittedForm
    from studies.fits.indices import InputIndices, SobolIndex
    from studies.fits.measured import MeasuredShots
    from studies.fits.surrogate import Prediction, Surrogate

app = typer.Typer()
COMMANDS = Commands("fitting", OUT_OF_A_CUBE, app)

TABLES = (".csv", ".tsv", ".txt")  # endings of tables of shots
MOST_LISTED = 10  # runs that are left out

QuantityOption = Annotated[
    str | None, typer.Option(metavar="NAME", help="The measured quantity; by default every one.")
]
At = Annotated[
    list[str] | None, typer.Option(metavar="AXIS=VALUE", help="Only points with this value: target=copper-ofhc.")
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
    quantity: QuantityOption = None,
    form: Annotated[str | None, typer.Option(metavar="NAME", help="The form of law; by default every one.")] = None,
    at: At = None,
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write the fit as a law that a sweep can name.")
    ] = None,
    name: Annotated[str, typer.Option(help="Name of that law.")] = "",
    as_json: Json = False,
) -> None:
    """Fit forms of laws to the points of a cube or to shots; compare them with each other and with published laws."""
    from studies.fits.fit import as_json as plain
    from studies.fits.fit import fits_of, forms_of
    from studies.fits.forms import FORMS

    fitted = []
    for measured in _measured(source, quantity, at or []):
        forms = forms_of(measured.quantity)
        chosen = [law for law in forms if form in (None, law.name)]
        if chosen:
            fitted.append(fits_of(measured, chosen))
    if not fitted:
        raise refusal("--form", str(form), "a form of law for what was measured", nearest_cure(form, FORMS))
    if out is not None:
        _write(fitted, out, name)
    if as_json:
        print_json([plain(fits) for fits in fitted])
    else:
        for fits in fitted:
            _print_fits(fits)
    if out is not None:
        print(f"written: {out}", file=sys.stderr)


@app.command()
def surrogate(
    cube: Annotated[Path, typer.Argument(metavar="CUBE", help="cube.nc of a sweep, or its folder.")],
    quantity: QuantityOption = None,
    at: Annotated[
        list[str] | None,
        typer.Option(metavar="AXIS=VALUE", help="Predict the value here: speed=6.2 km/s; for every axis."),
    ] = None,
    plot: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Draw predicted over computed values: PNG, SVG or PDF.")
    ] = None,
    as_json: Json = False,
) -> None:
    """Interpolate the runs of a cube with an error, and say which axis matters. Needs the extra 'surrogate'."""
    from studies.cubes.opening import whole_cube
    from studies.fits.indices import indices_of_surrogate
    from studies.fits.surrogate import as_json as plain
    from studies.fits.surrogate import check_extra, main_quantity, surrogate_of

    check_extra()
    dataset = whole_cube(cube)
    made = surrogate_of(dataset, main_quantity(dataset, quantity))
    place = made.runs.read_place(at) if at else None
    prediction = None if place is None else made.predict(place[None])
    indices = indices_of_surrogate(made)
    if as_json:
        document = {**plain(made), "indices": [*map(asdict, indices)]}
        if place is not None and prediction is not None:
            names = [axis.name for axis in made.runs.inputs]
            document["prediction"] = {
                "at": dict(zip(names, place.tolist(), strict=True)),
                "value": float(prediction.values[0]),
                "interval": float(prediction.intervals[0]),
            }
        print_json(document)
    else:
        _print_surrogate(made, indices)
        if prediction is not None:
            _print_prediction(made, prediction, at or [])
    if plot is not None:
        from studies.fits.surrogate import draw_left_out

        draw_left_out(made, plot)
        print(f"written: {plot}", file=sys.stderr)


def _print_surrogate(made: "Surrogate", indices: "list[InputIndices]") -> None:
    from studies.fits.surrogate import KERNEL

    runs, left = made.runs, made.left_out
    shown = display_of(runs.unit)
    words, unit = runs.quantity.replace("_", " "), f" {shown.unit}" if shown.unit else ""
    print(f"{words}: {runs.scope}; {runs.source}")
    for id, reason in runs.left_out[:MOST_LISTED]:
        print(f"  left out: run {id[:SHORT_ID]}, {reason}")
    if len(runs.left_out) > MOST_LISTED:
        print(f"  left out: {len(runs.left_out) - MOST_LISTED} others; --json names all")
    lengths = ", ".join(f"{name.replace('_', ' ')} {length:.2g}" for name, length in made.lengths.items())
    bends, noise = (f"{size * shown.factor:.2g}{unit}" for size in made.deviations.values())
    print(f"  kernel: {KERNEL}, most likely:")
    print(f"  lengths over the range of the input: {lengths}; bends {bends}; noise {noise}")
    freedom = f"{made.degrees_of_freedom} degrees of freedom"
    print(f"  intervals: its deviation times {made.scale:.2g}, Student's t with {freedom}")
    columns = [with_unit(axis.name.replace("_", " "), axis.unit) for axis in runs.inputs]
    rows = [
        (
            id[:SHORT_ID],
            *(f"{value * display_of(axis.unit).factor:.6g}" for value, axis in zip(place, runs.inputs, strict=True)),
            *(f"{value * shown.factor:.5g}" for value in numbers),
            "" if abs(numbers[1] - numbers[0]) <= numbers[2] else "outside",
        )
        for id, place, *numbers in zip(
            runs.ids, runs.places, runs.values, left.predicted.values, left.predicted.intervals, strict=True
        )
    ]
    heading = with_unit("computed", runs.unit)
    print_table(("run", *columns, heading, "predicted without it", "± 95 %", ""), rows)
    for what, errors in (("run", left), ("point", made.points_left_out)):
        sizes = f"rms error {errors.rms * shown.factor:.3g}{unit}, largest {errors.largest * shown.factor:.3g}{unit}"
        print(
            f"  each {what} left out once: {sizes}, Q2 {errors.explained:.4f}; "
            f"95 % intervals cover {errors.coverage:.0%}"
        )
    print("Sobol indices (95 %)")
    table = ((axis.name, _index(axis.first), _index(axis.total)) for axis in indices)
    print_table(("axis", "by itself", "with interactions"), table)


def _index(index: "SobolIndex") -> str:
    return f"{index.value:.3f} ({index.low:.3f} to {index.high:.3f})"


def _print_prediction(made: "Surrogate", prediction: "Prediction", at: list[str]) -> None:
    shown = display_of(made.runs.unit)
    value, interval = (float(numbers[0]) * shown.factor for numbers in (prediction.values, prediction.intervals))
    unit = f" {shown.unit}" if shown.unit else ""
    print(f"predicted at {', '.join(at)}: {value:.4g} ± {interval:.2g}{unit} (95 %, for a run)")


def _measured(source: str, quantity: str | None, at: list[str]) -> "list[MeasuredShots]":
    """The points of a cube or a table; raises InvalidInput."""
    from studies import observations
    from studies.cubes.opening import whole_cube
    from studies.fits.forms import SIZES
    from studies.fits.measured import of_cube, of_table, quantities_of

    if source.lower().endswith(TABLES) or (source in observations.names() and not Path(source).exists()):
        every = list(of_table(source, SIZES))
    else:
        dataset = whole_cube(Path(source))
        every = [of_cube(dataset, name) for name in quantities_of(dataset, SIZES)]
    chosen = [measured for measured in every if quantity in (None, measured.quantity)]
    if not chosen:
        there = ", ".join(measured.quantity for measured in every) or "none that a law is about"
        raise refusal("--quantity", str(quantity), f"one that {source} has", f"it has: {there}")
    return [measured.at(measured.read_place(at)) for measured in chosen]


def _write(fitted: "list[list[FittedForm]]", out: Path, name: str) -> None:
    """Write the only fit into a file; raises InvalidInput where there are several, or none."""
    done = [fit for fits in fitted for fit in fits if fit.solution is not None]
    if len(done) != 1:
        there = ", ".join(f"{fit.measured.quantity} {fit.form.name}" for fit in done) or "none"
        cure = "choose with --quantity and --form" if done else "see the reasons without --out"
        raise refusal("--out", there, "one fit", cure)
    law = done[0].law(name)
    out.write_text(json.dumps(law.document(), indent=1, ensure_ascii=False, allow_nan=False) + "\n", "utf-8")


def _print_fits(fits: "list[FittedForm]") -> None:
    from studies.fits.fit import compared, verdicts
    from studies.fits.forms import dimension_of

    measured = fits[0].measured
    weights = "weighted by their uncertainties" if measured.errors is not None else "equal weights"
    left_out = "".join(f"; {count} left out: {reason}" for reason, count in measured.left_out.items())
    words = measured.quantity.replace("_", " ")
    print(f"{words}: {len(measured.shots)} points, {weights}{left_out}\n  {measured.source}")
    differences = {
        fit.form.name: size
        for ranked in compared(fits)
        if len(ranked.fits) > 1
        for fit, size in zip(ranked.fits, ranked.differences, strict=True)
    }
    dimension = dimension_of(measured.quantity)
    unit = "mm" if dimension == 1 else f"mm{dimension}"
    texts = {name: f"{difference:.1f}" for name, difference in differences.items()}
    rows = [row for fitted in fits for row in _rows(fitted, texts.get(fitted.form.name, ""), dimension)]
    columns = ("form", "equation", "constants (95 %)", f"in {unit}", f"rms ({unit})", "AICc - best")
    print_table(columns, rows)
    for sentence in verdicts(fits):
        print(f"  {sentence}")


def _rows(fitted: "FittedForm", difference: str, dimension: int) -> Iterator[tuple[str, ...]]:
    """The row of a fit, and one of each published law of its form."""
    equation = fitted.form.equation_for(fitted.measured.quantity)
    if fitted.solution is None:
        yield fitted.form.name, equation, fitted.reason, "", "", ""
        return
    constants = ", ".join(
        f"{name} = {_short(value.value)} ({_short(value.low)} to {_short(value.high)})"
        for name, value in fitted.constants.items()
    )
    sizes = ", ".join(map(_short, (fitted.in_millimetres() or {}).values()))
    yield fitted.form.name, equation, constants, sizes, f"{fitted.rms * 1e3**dimension:.2f}", difference
    for law in fitted.published:
        stated = zip(fitted.form.constants, law.constants, strict=True)
        yield "", f"  {law.title}", ", ".join(f"{name} = {_short(value)}" for name, value in stated), "", "", ""


def _short(value: float) -> str:
    return f"{value:.3g}"
