"""The files of a calibration (draws, a material file, materials for a sweep), and what it says in sentences."""

import json
import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import xarray as xr

from studies.fits.calibration.design import CONSTANTS, LOGARITHMIC
from studies.fits.calibration.posterior import Posterior
from studies.fits.calibration.prediction import LEVEL, PredictedShots, chances
from studies.materials import Material
from studies.quantities.display import display_alone
from studies.quantities.files import write_atomically, write_text
from studies.quantities.parameters import Plain
from studies.quantities.units import round_quantity

DRAWS_FILE, MATERIAL_FILE, SWEEP_FILE = "calibration.nc", "material.toml", "materials.yaml"
IN_SWEEP = 16  # draws that are written as materials of a sweep
FEW = 400  # independent draws, below which ends of intervals are rough: 5 % of 400 are 20 draws
CLOSE = 0.02  # of a prior range: so near to where the end of a uniform distribution would be, the range decides it

REMARK = (
    "# Draws of {material} calibrated to {table}, equally likely. Copy them into a sweep of {material}: with\n"
    "# `model_part: screen` the spread of their answers is a strength part. Or name them on an axis."
)
UNITS = {"A": "Pa", "B": "Pa", "n": "1", "C": "1", "m": "1"}


def values_of(posterior: Posterior, drawn: np.ndarray) -> dict[str, np.ndarray]:
    """The constants of draws (draws, 5) by name, SI."""
    columns = zip(CONSTANTS, drawn.T, strict=True)
    return {name: np.exp(column) if name in LOGARITHMIC else column for name, column in columns}


def dataset_of(posterior: Posterior, predicted: PredictedShots, attributes: Mapping[str, str]) -> xr.Dataset:
    """The draws and the shots that they were held against."""
    shots = posterior.calibration.shots
    further, of_series = np.exp(posterior.further_lots()[:, 0]), np.exp(posterior.lots)
    variables = {
        name: _variable("draw", column, f"Johnson-Cook {name}{', middle of all lots' * (name == 'A')}", UNITS[name])
        for name, column in values_of(posterior, posterior.constants).items()
    }
    variables |= {
        "A_of_further_lot": _variable("draw", further, "Johnson-Cook A of a lot that was not shot", "Pa"),
        "A_of_series": _variable(("draw", "series"), of_series, "A of each series", "Pa"),
        "lots_deviation": _variable("draw", posterior.lots_deviation, "standard deviation of ln A between lots"),
        "bias": _variable(("draw", "quantity"), posterior.biases, "ln of measured over computed strain"),
        "scatter": _variable(("draw", "quantity"), posterior.scatters, "scatter of the strain, relative"),
        "shot_series": xr.Variable("shot", shots.series),
        "shot_quantity": xr.Variable("shot", shots.quantities),
    }
    columns = {"speed": (shots.speeds, "m/s"), "length_over_diameter": (shots.ratios, "1")}
    columns |= {"measured": (predicted.measured, "m"), "predicted": (predicted.median, "m")}
    columns |= {"predicted_low": (predicted.low, "m"), "predicted_high": (predicted.high, "m")}
    variables |= {
        f"shot_{name}": xr.Variable("shot", column, {"units": unit}) for name, (column, unit) in columns.items()
    }
    coordinates = {"series": shots.lots, "quantity": shots.names}
    return xr.Dataset(variables, coordinates, {"level": LEVEL, **attributes})


def _variable(dims: str | tuple[str, ...], values: np.ndarray, meaning: str, unit: str = "1") -> xr.Variable:
    return xr.Variable(dims, values, {"units": unit, "long_name": meaning})


def calibrated(material: Material, posterior: Posterior, name: str, source: str) -> Material:
    """The material with the mean of all draws of a further lot (of ln A and ln B, n, C and m)."""
    row = posterior.further_lots().mean(axis=0)[None]
    made = replace(material, name=name, title=f"{material.title}, calibrated")
    for constant, column in values_of(posterior, row).items():
        made = made.with_value(f"strength.{constant}", round_quantity(float(column[0])), source=source)
    return made


def write(
    folder: Path, material: Material, posterior: Posterior, predicted: PredictedShots, table: str
) -> Iterator[Path]:
    """Write the files of a calibration into a folder, and yield each."""
    source = f"calibrated to {table}: mean of {len(posterior.constants)} draws of the posterior, {DRAWS_FILE}"
    name = f"{material.name}-calibrated"
    attributes = {"title": f"Johnson-Cook constants of {material.name} from {table}", "material": material.name}
    dataset = dataset_of(posterior, predicted, {**attributes, "table": table})
    yield write_atomically(folder / DRAWS_FILE, dataset.to_netcdf)
    yield write_text(folder / MATERIAL_FILE, as_toml(calibrated(material, posterior, name, source)))
    texts = [REMARK.format(material=material.name, table=table), "materials:"]
    # Evenly spaced over all: the chains stand one after another in time.
    chosen = np.linspace(0, len(posterior.constants) - 1, IN_SWEEP).round().astype(int)
    for number, drawn in enumerate(chosen, 1):
        row = values_of(posterior, posterior.further_lots()[drawn : drawn + 1])
        constants = ", ".join(
            f"{key}: {float(column[0]) / 1e6:.4g} MPa" if UNITS[key] == "Pa" else f"{key}: {float(column[0]):.4g}"
            for key, column in row.items()
        )
        texts.append(f"  {name}-{number}: {{base: {material.name}, strength: {{{constants}}}}}")
    yield write_text(folder / SWEEP_FILE, "\n".join(texts) + "\n")


def as_toml(material: Material) -> str:
    """A material as a TOML file that reads as itself."""
    lines: list[str] = []

    def table(path: str, content: Mapping[str, Plain], brackets: str = "[{}]") -> None:
        plain = {key: value for key, value in content.items() if not isinstance(value, Mapping | list)}
        if plain and path:
            lines.extend(["", brackets.format(path)])
        lines.extend(f"{key} = {json.dumps(value, ensure_ascii=False)}" for key, value in plain.items())
        for key, value in content.items():
            below = f"{path}.{key}" if path else key
            if isinstance(value, Mapping):
                table(below, value)
            elif isinstance(value, list):
                for part in value:
                    table(below, part, "[[{}]]")

    table("", material.document())
    return "\n".join(lines) + "\n"


# ---- sentences -----------------------------------------------------------------------------------


def sentences(posterior: Posterior, predicted: PredictedShots) -> Iterator[str]:
    """What a calibration says, each with units."""
    shots, level = posterior.calibration.shots, f"{100 * LEVEL:g} %"
    counts = ", ".join(f"{int((shots.quantities == name).sum())} of {_words(name)}" for name in shots.names)
    yield f"{len(shots.strains)} measured sizes ({counts}) of {len(shots.lots)} series."
    for name, column in values_of(posterior, posterior.constants).items():
        text = _interval(column, UNITS[name])
        low, high = posterior.calibration.prior[CONSTANTS.index(name)]
        logarithm = np.log(column) if name in LOGARITHMIC else column
        ends = np.quantile(logarithm, (0.5 - 0.5 * LEVEL, 0.5 + 0.5 * LEVEL))
        near = [
            word
            for word, gap in (("lower", ends[0] - low), ("upper", high - ends[1]))
            if gap < 0.5 * (1.0 - LEVEL) * (high - low) + CLOSE * (high - low)
        ]
        doubt = f"; the {' and the '.join(near)} end is that of the prior range, not of the shots" if near else ""
        yield f"{name} is {text} ({level}){doubt}."
    further = _interval(np.exp(posterior.further_lots()[:, 0]), "Pa")
    deviation = _interval(posterior.lots_deviation, "1")
    yield f"Between lots ln A has a standard deviation of {deviation} ({level})."
    yield f"A of a lot that was not shot is {further} ({level})."
    for number, lot in enumerate(shots.lots):
        count = int((shots.series == lot).sum())
        yield f"A of {lot}, {count} sizes, is {_interval(np.exp(posterior.lots[:, number]), 'Pa')} ({level})."
    for number, name in enumerate(shots.names):
        bias, scatter = posterior.biases[:, number], posterior.scatters[:, number]
        emulator = posterior.calibration.emulators[name]
        yield (
            f"Measured strains of the {_words(name)} are {_interval(100.0 * np.expm1(bias), '1')} % off the computed "
            f"ones, and scatter by {_interval(100.0 * scatter, '1')} % ({level}); the emulator errs by "
            f"{100.0 * emulator.error:.1f} %."
        )
    yield f"{int(predicted.inside.sum())} of {len(predicted.inside)} of these sizes are in their {level} intervals."
    if posterior.effective < FEW:
        yield f"The chains are worth {posterior.effective:.0f} independent draws only: ends of intervals are rough."


def sentences_left_out(series: Iterable[tuple[str, PredictedShots]]) -> Iterator[str]:
    """How each series that was left out is predicted from the others, and all of them together."""
    level, every = f"{100 * LEVEL:g} %", []
    for lot, predicted in series:
        every.append(predicted)
        count, total = int(predicted.inside.sum()), len(predicted.inside)
        yield (
            f"Without {lot}: {count} of its {total} sizes are in the {level} intervals from the other series; they are "
            f"{100.0 * predicted.offset:+.1f} % off the medians on average."
        )
    inside = np.concatenate([predicted.inside for predicted in every])
    fewer, more = chances(every)
    yield (
        f"All series left out in turn: {inside.sum()} of {len(inside)} sizes are in their {level} intervals. Of series "
        f"as predicted no more are with a chance of {100.0 * fewer:.2g} %, no fewer with one of {100.0 * more:.2g} %."
    )


def _words(name: str) -> str:
    return name.replace("_", " ")


def _interval(values: np.ndarray, unit: str) -> str:
    """Median and ends at ``LEVEL``, with the unit."""
    low, median, high = np.quantile(values, (0.5 - 0.5 * LEVEL, 0.5, 0.5 + 0.5 * LEVEL)).tolist()
    shown = display_alone(median, unit) if unit != "1" else None
    factor, text = (shown.factor, f" {shown.unit}") if shown else (1.0, "")
    digits = max(0, 2 - math.floor(math.log10(max(abs(low), abs(median), abs(high), 1e-12) * factor)))
    return f"{median * factor:.{digits}f} ({low * factor:.{digits}f} to {high * factor:.{digits}f}){text}"
