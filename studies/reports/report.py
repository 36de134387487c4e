"""The report: everything that is said about a sweep, as one document of plain objects in SI.

:func:`document` gathers it from the cube alone, for ``report.json``. :mod:`studies.reports.page` prints the same
document as one HTML file that opens from disk without a network.
"""

import json
import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from studies.convergence.richardson import COVERAGE, ORDERS, SAFETY
from studies.cubes import audit, reading
from studies.cubes import variables as cubes
from studies.cubes.long_texts import short_texts, with_short_texts
from studies.cubes.points import (
    Refined,
    axes_of,
    by_run,
    error_bars,
    main_quantities,
    places_of,
    plain,
    refined,
    refinements_of,
)
from studies.cubes.reading import finite
from studies.cubes.variable import Variable, variable_name
from studies.cubes.variables import STATES
from studies.quantities.findings import InvalidInput
from studies.reports import openings
from studies.reports.compare import Comparison, published_shots
from studies.reports.figure import Figure
from studies.reports.figures import figures, fragment_sizes
from studies.reports.limits.outcomes import limits_of, outcomes_of
from studies.reports.limits.residual import residual_curves, residual_figure
from studies.reports.limits.shield import shield_limits
from studies.reports.limits.shield_figure import shield_figure
from studies.reports.limits.shield_probability import chances_of, in_words
from studies.reports.limits.shield_verdict import ShieldTerms, verdict_on_equations
from studies.reports.methods import methods_of
from studies.reports.opening import headline, is_made_by_mesh, opening_of
from studies.reports.pictures import pictures_of
from studies.sweeps.reading import ACCEPTED, OFFSET, RESOLUTION
from studies.sweeps.screening import CONTRIBUTIONS
from studies.sweeps.sweep import Sweep
from studies.sweeps.warnings import doubtful_constants

REPORT_VERSION = 15

RULES = (
    "The value is that of the finest resolution, the mean over its sub-cell offsets; the number behind ± is their "
    "standard deviation. Where the three finest resolutions show an order of "
    f"{ORDERS[0]:g} to {ORDERS[1]:g} (Celik et al. 2008, J. Fluids Eng. 130, 078001), with {COVERAGE:g} times their "
    "noise against it, a point is converging, and its mesh error is the grid convergence index of the values so "
    f"shifted, factor {SAFETY:g} (Roache 1994). Elsewhere the order and the mesh error are unknown."
)
NO_MESH_ERROR = (
    "The mesh error, which takes several resolutions to estimate, is unknown: there is no error bar, and no law is "
    "called inside or outside of it. What a measurement states for its reading on one grid is in the cube."
)


def document(dataset: xr.Dataset, comparison: Comparison, sections: Mapping[str, Path] | None = None) -> dict[str, Any]:
    """Everything that the report says, as plain objects in SI; ``sections`` are files by run id.

    A text of several lines, a deck, stands by its first line and digest: the cube has it in full.
    """
    runs, points, compared = list(_runs(dataset)), comparison.points, comparison.as_json()
    report = {
        "report_version": REPORT_VERSION,
        "title": dataset.attrs["title"],
        "scenario": {"name": dataset.attrs["scenario"], "title": dataset.attrs["scenario_title"]},
        "headline": "",
        "overview": _overview(runs),
        "doubts": _doubts(dataset),
        "mesh": _mesh(dataset),
        "axes": [_axis(dataset, name) for name in axes_of(points)],
        "refinements": [_axis(dataset, name) for name in refinements_of(dataset)],
        "coordinates": [_axis(dataset, name) for name in axes_of(dataset)],
        "fixed": list(_fixed(dataset)),
        "quantities": list(_quantities(dataset)),
        "extremes": list(_extremes(points)),
        "withheld": list(_withheld(points)),
        "figures": [figure.as_json() for figure in every_figure(dataset, comparison)],
        "outcomes": outcomes_of(points),
        "limits": limits_of(dataset),
        "ballistic_limit": _ballistic_limit(dataset, points),
        "residual_curves": residual_curves(dataset),
        "pictures": pictures_of(dataset, sections or {}),
        "methods": methods_of(dataset, points),
        "convergence": _convergence(dataset, points) if refinements_of(dataset) else None,
        **compared,
        "runs": runs,
        "audit": list(_audit(dataset)),
        "laws": list(_laws(dataset)),
        "model_part": list(_model_part(dataset)),
        "published_shots": published_shots(dataset),
        "materials": _materials(dataset),
        "provenance": _provenance(dataset),
    }
    report["headline"] = _headline(report, comparison)
    shortened: dict[str, Any] = with_short_texts(report, short_texts(dataset))
    return shortened


def _doubts(dataset: xr.Dataset) -> list[str]:
    """Doubts about the constants of a sweep; none of a sweep of another version."""
    with suppress(InvalidInput):
        return list(doubtful_constants(Sweep.parse(json.loads(dataset.attrs["sweep"]), ACCEPTED)))
    return []


def every_figure(dataset: xr.Dataset, comparison: Comparison) -> list[Figure]:
    """The figures of a report, limits first."""
    return [
        *shield_figure(dataset, shield_limits(comparison.points)),
        *residual_figure(dataset, residual_curves(dataset)),
        *figures(dataset, comparison),
        *fragment_sizes(dataset, comparison.points),
    ]


def as_json(report: dict[str, Any]) -> str:
    """The report as JSON; NaN becomes null."""
    return json.dumps(report, ensure_ascii=False, allow_nan=False, indent=1) + "\n"


# ---- what the document says ----------------------------------------------------------------------


def _headline(report: Mapping[str, Any], comparison: Comparison) -> str:
    """What the report opens with: a shield, the limit of a search, what methods change, an outcome, or values."""
    if comparison.mixed:
        return openings.of_mixed([*comparison.mixed])
    if report["ballistic_limit"]:
        return str(report["ballistic_limit"].pop("headline"))
    if report["limits"]:
        return openings.of_limits(report["limits"])
    if report["methods"] and (text := openings.of_methods(report["methods"])):
        return text
    if report["outcomes"] and (text := openings.of_outcomes(report["outcomes"][0], report)):
        return text
    points = comparison.points
    opening = opening_of(points, comparison.judgements, comparison.shots)
    units = {each["name"]: each["unit"] for each in report["axes"]}
    return headline(opening, units) if opening else openings.NONE


def _ballistic_limit(dataset: xr.Dataset, points: xr.Dataset) -> dict[str, Any] | None:
    """The verdict on the equations of a shield; None where the sweep has none."""
    limits = shield_limits(points)
    if not limits:
        return None
    shapes = set(by_run(points, "projectile_shape"))
    units = {name: points[name].attrs.get("units") for name in limits[0].at}
    what = "spheres" if shapes == {"sphere"} else "projectiles"
    terms = ShieldTerms(units, what, has_grids=bool(refinements_of(dataset)))
    verdict = verdict_on_equations(limits, terms)
    chances = in_words(limits, chances_of(dataset, points, limits), terms)
    headline = chances.pop("headline") or verdict["headline"]
    return {**verdict, "headline": headline, "probability": chances}


def _overview(runs: Sequence[dict[str, Any]]) -> dict[str, Any]:
    states = Counter(run["state"] for run in runs)
    return {
        "runs": len(runs),
        "states": [{"state": state, "runs": states[state]} for state in STATES if states[state]],
        "flagged": sum(run["doubted"] for run in runs),
        "flagged_elsewhere": sum(bool(run["flags"]) and not run["doubted"] for run in runs),
        "without_value": sum(run["state"] == "succeeded" and not run["has_value"] for run in runs),
    }


def _mesh(dataset: xr.Dataset) -> str:
    """A statement of the runs behind a point, and of the parts of its error bar."""
    several = refinements_of(dataset)
    if not several:
        return f"Every point is one run on one mesh. {NO_MESH_ERROR}"
    levels = [
        f"{dataset.sizes[name]} {label}"
        for name, label in ((RESOLUTION, "resolutions"), (OFFSET, "sub-cell offsets"))
        if name in several
    ]
    value, note = "the mean over offsets", NO_MESH_ERROR
    if RESOLUTION in several:
        value = "that of the finest resolution"
        note = (
            "Its error bar is the root of the sum of the squares of mesh error, scatter over offsets and the other "
            "uncertainties of the measurement; without the first there is none."
        )
    return (
        f"Every point was computed with {' and '.join(levels)}. Laws and observations are compared with one value a "
        f"point: {value}. {note}"
    )


def _convergence(dataset: xr.Dataset, points: xr.Dataset) -> dict[str, Any]:
    """Values by resolution, orders, error bars and verdicts of each quantity at each point."""
    places = places_of(points)
    quantities = []
    for quantity in _quantities(dataset):
        rows = [_refined(point, places) for point in refined(dataset, quantity["name"])]
        counts = Counter(row["verdict"] for row in rows)
        quantities.append(
            {
                "quantity": quantity["name"],
                **{key: quantity[key] for key in ("label", "unit", "main")},
                "points": rows,
                "verdicts": [{"verdict": verdict, "points": count} for verdict, count in counts.most_common()],
            }
        )
    several = RESOLUTION in refinements_of(dataset)
    resolutions = dataset[RESOLUTION].values.tolist() if several else [None]
    return {"rules": RULES, "resolutions": resolutions, "quantities": quantities}


def _refined(point: Refined, places: Sequence[Mapping[str, float | str]]) -> dict[str, Any]:
    converged = point.converged
    parts = ("value", "mesh", "offsets", "measurement")
    extrapolation = ("order", "extrapolated", "gci")
    return {
        "at": places[point.number],
        "verdict": converged.verdict,
        "reason": converged.reason,
        "uncertainty": None if math.isnan(converged.mesh) else finite(converged.uncertainty),
        **{name: finite(getattr(converged, name)) for name in (*parts, *extrapolation)},
        "levels": [
            {
                "spacing": level.spacing,
                "value": finite(level.value),
                "scatter": finite(level.scatter),
                "values": level.values,
                "runs": level.runs,
            }
            for level in reversed(converged.levels)
        ],
    }


def _axis(dataset: xr.Dataset, name: str) -> dict[str, Any]:
    axis = dataset[name]
    values = list(dict.fromkeys(plain(value) for value in axis.values))
    return {"name": name, "unit": axis.attrs.get("units"), "meaning": reading.meaning_of(axis), "values": values}


def _fixed(dataset: xr.Dataset) -> Iterator[dict[str, Any]]:
    """Parameters that all runs share."""
    parameters = json.loads(dataset.attrs["vocabulary"])["parameters"]
    for parameter, (_, unit, meaning) in parameters.items():
        name = variable_name(parameter)
        if name in dataset and not dataset[name].dims:
            value = finite(plain(dataset[name].item()))
            if value not in (None, ""):
                yield {"name": parameter, "value": value, "unit": unit, "meaning": meaning}


def _quantities(dataset: xr.Dataset) -> Iterator[dict[str, Any]]:
    main = main_quantities(dataset)
    for name in reading.quantities_of(dataset):
        yield {
            "name": name,
            "label": name.replace("_", " "),
            "unit": dataset[name].attrs["units"],
            "meaning": reading.meaning_of(dataset[name]),
            "main": name in main,
        }


def _withheld(dataset: xr.Dataset) -> Iterator[dict[str, Any]]:
    """The main quantities with values that are no answer, and how many."""
    for name in main_quantities(dataset):
        if count := int(is_made_by_mesh(dataset, name).sum()):
            yield {"quantity": name.replace("_", " ").capitalize(), "points": count, "of": dataset.run_state.size}


def _extremes(dataset: xr.Dataset) -> Iterator[dict[str, Any]]:
    """Smallest and largest value of each main quantity, and where; without those that are no answer."""
    places = places_of(dataset)
    for name in main_quantities(dataset):
        values = np.where(is_made_by_mesh(dataset, name), np.nan, dataset[name].values.ravel())
        bars = error_bars(dataset, name).values.ravel()
        if np.isfinite(values).any():
            low, high = int(np.nanargmin(values)), int(np.nanargmax(values))
            yield {
                "quantity": name.replace("_", " "),
                "unit": dataset[name].attrs["units"],
                "smallest": float(values[low]),
                "smallest_uncertainty": finite(float(bars[low])),
                "smallest_at": places[low],
                "largest": float(values[high]),
                "largest_uncertainty": finite(float(bars[high])),
                "largest_at": places[high],
            }


def _runs(dataset: xr.Dataset) -> Iterator[dict[str, Any]]:
    """Each run, with the values of its cell by the names of the cube's variables."""
    columns = {name: by_run(dataset, name) for name in _run_variables(dataset)}
    texts = {
        key: variable.of(dataset).values.ravel()
        for key, variable in (
            ("id", cubes.RUN_ID),
            ("reason", cubes.RUN_REASON),
            ("failure", cubes.RUN_FAILURE),
            ("stop", cubes.STOP_REASON),
        )
    }
    flags = _flags(dataset)
    states = cubes.RUN_STATE.of(dataset).values.ravel()
    main = main_quantities(dataset)
    lengths = [name for name in main if dataset[name].attrs["units"] == "m"]
    doubted = np.logical_or.reduce(
        [cubes.FLAGS_OF_RUN.of(dataset).values.ravel() != 0]
        + [reading.doubts(cubes.FLAGS.of(dataset, name)).values.ravel() != 0 for name in main]
    )
    for number, place in enumerate(places_of(dataset)):
        values = {name: finite(float(column[number])) for name, column in columns.items()}
        diameter = values.get(cubes.EQUIVALENT_DIAMETER.name)
        yield {
            "number": number,
            "at": place,
            "state": STATES[states[number]],
            **{key: str(column[number]) for key, column in texts.items()},
            "flags": flags[number],
            # By a flag of the run itself or of a main quantity: the value is drawn as an open mark.
            "doubted": bool(doubted[number]),
            "has_value": any(values[name] is not None for name in main),
            "values": values,
            # Lengths over the projectile's diameter.
            "ratios": {name: None if None in (values[name], diameter) else values[name] / diameter for name in lengths},
        }


def _run_variables(dataset: xr.Dataset) -> list[str]:
    """Numbers that a run has one of: quantities, uncertainties, audit, time, diameter."""
    axes = set(axes_of(dataset))
    return [
        str(name)
        for name, array in dataset.variables.items()
        if array.dtype.kind == "f"
        and name not in axes
        and (array.dims == dataset.run_state.dims or name == cubes.EQUIVALENT_DIAMETER.name)
    ]


def _flags(dataset: xr.Dataset) -> list[list[str]]:
    """All flags of each run, those of a quantity with its name."""
    columns = {"": reading.flag_words(cubes.FLAGS_OF_RUN.of(dataset))}
    for name in reading.quantities_of(dataset):
        columns[f"{name}: "] = reading.flag_words(cubes.FLAGS.of(dataset, name))
    return [
        [f"{quantity}{flag}".replace("_", " ") for quantity, column in columns.items() for flag in column[number]]
        for number in range(dataset.run_state.size)
    ]


def _audit(dataset: xr.Dataset) -> Iterator[dict[str, Any]]:
    """For each number of the audit: its range, and the run that is farthest from zero."""
    places = places_of(dataset)
    for number in audit.AUDIT:
        name, limit = number.variable.name, number.limit
        if number.shown and name in dataset and np.isfinite(dataset[name]).any():
            values = dataset[name].values.ravel()
            yield {
                "variable": name,
                "label": number.name.replace("_", " "),
                "meaning": number.meaning,
                "unit": number.unit,
                "kind": "share" if number.share else "plain",
                "smallest": float(np.nanmin(values)),
                "median": float(np.nanmedian(values)),
                "largest": float(np.nanmax(values)),
                "farthest_at": places[int(np.nanargmax(np.abs(values)))],
                "limit": limit,
                "over_limit": None if limit is None else int((np.abs(values) > limit).sum()),
            }


def _model_part(dataset: xr.Dataset) -> Iterator[dict[str, Any]]:
    """Each statement of what the models leave open of a quantity, in numbers too, with the runs that it is about."""
    for quantity in reading.quantities_of(dataset):
        shares = {name: _by_run(dataset, cubes.model_contribution(name), quantity) for name in CONTRIBUTIONS}
        factors = _by_run(dataset, cubes.MODEL_DISTANCE, quantity)
        texts = by_run(dataset, cubes.MODEL_REASON.named(quantity)).astype(str)
        for text, count in Counter(filter(None, texts.tolist())).items():
            mine = texts == text
            distances = factors[mine & np.isfinite(factors)]
            yield {
                "quantity": quantity,
                "statement": text,
                "contributions": {name: finite(float(share[mine][0])) for name, share in shares.items()},
                "lower": _side(dataset, quantity, cubes.MODEL_SIDES[0], mine),
                "upper": _side(dataset, quantity, cubes.MODEL_SIDES[1], mine),
                "thrown_out": _thrown_out(dataset, quantity, mine),
                # The largest factor by which they are outside of where their model part was measured.
                "distance": float(distances.max()) if distances.size else None,
                "runs": count,
            }


def _side(
    dataset: xr.Dataset, quantity: str, side: tuple[Variable, Variable], mine: np.ndarray
) -> dict[str, Any] | None:
    """How far failures that count move some runs to one side, relative, and which; None where it is not known."""
    sizes, values = _by_run(dataset, side[0], quantity)[mine], by_run(dataset, quantity)[mine]
    if not np.isfinite(sizes[0]):
        return None
    failure = by_run(dataset, side[1].named(quantity))[mine][0]
    return {"share": abs(float(sizes[0] / values[0])) if values[0] else None, "failure": str(failure)}


def _thrown_out(dataset: xr.Dataset, quantity: str, mine: np.ndarray) -> list[str]:
    """The failures that do not count for some runs."""
    if not cubes.MODEL_THROWN_OUT.is_in(dataset, quantity):
        return []
    names = by_run(dataset, cubes.MODEL_THROWN_OUT.named(quantity))[mine][0]
    return [name for name in str(names).split(cubes.BETWEEN_FAILURES) if name]


def _by_run(dataset: xr.Dataset, variable: Variable, quantity: str) -> np.ndarray:
    """A number of a quantity for each run, (runs,); NaN where no run has it."""
    if not variable.is_in(dataset, quantity):
        return np.full(dataset.run_state.size, np.nan)
    return by_run(dataset, variable.named(quantity))


LAW_TEXTS = {
    "name": cubes.LAW_NAME,
    "title": cubes.LAW_TITLE,
    "equation": cubes.LAW_EQUATION,
    "source": cubes.LAW_SOURCE,
    "range": cubes.LAW_RANGE,
    "confidence": cubes.LAW_CONFIDENCE,
}


def _laws(dataset: xr.Dataset) -> Iterator[dict[str, Any]]:
    """Each law once, with the constants that it was evaluated with."""
    for quantity in (*reading.quantities_of(dataset), *reading.critical_of(dataset)):
        if not cubes.LAW_LABEL.is_in(dataset, quantity):
            continue
        texts = {key: variable.of(dataset, quantity).values for key, variable in LAW_TEXTS.items()}
        variants, reasons, scatter = (
            variable.of(dataset, quantity).values
            for variable in (cubes.LAW_VARIANT, cubes.BY_LAW_REASON, cubes.LAW_SCATTER)
        )
        for law in dict.fromkeys(texts["name"]):
            rows = np.flatnonzero(texts["name"] == law)
            counts = Counter(str(reason) for reason in reasons[..., rows].ravel() if reason)
            yield {
                **{key: str(column[rows[0]]) for key, column in texts.items()},
                "scatter": finite(float(scatter[rows[0]])),
                "quantity": quantity.replace("_", " "),
                "variants": [str(variants[row]) for row in rows if variants[row]],
                "reasons": [{"reason": reason, "answers": count} for reason, count in counts.most_common()],
            }


def _materials(dataset: xr.Dataset) -> list[dict[str, Any]]:
    materials = json.loads(dataset.attrs["materials"])
    return [
        {
            "name": name,
            "title": material["title"],
            "numbers": [{"path": path, **number} for path, number in material["numbers"].items()],
        }
        for name, material in materials.items()
    ]


def _provenance(dataset: xr.Dataset) -> dict[str, Any]:
    attributes = dataset.attrs
    return {
        "cube": {
            name: attributes[name]
            for name in ("Conventions", "institution", "source", "date_created", "undeclared_numbers")
            if name in attributes
        },
        "schema_version": int(attributes["schema_version"]),
        "software": json.loads(attributes["software"]),
        "sweep": json.loads(attributes["sweep"]),
    }
