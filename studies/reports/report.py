"""The report: everything that is said about a sweep, as one document of plain objects in SI.

:func:`document` gathers it from the cube alone; it is the JSON twin. :mod:`studies.reports.page` prints the same
document as one HTML file that opens from disk without a network.
"""

import json
import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from studies.convergence.richardson import (
    ASSUMED_ORDER,
    ORDERS,
    SAFETY,
    SAFETY_UNOBSERVED,
    VERDICTS,
)
from studies.cubes.variables import NUMBERS, STATES
from studies.reports.compare import Comparison
from studies.reports.places import axes_of, places_of, plain
from studies.reports.points import Refined, points_of, refined, refinements_of
from studies.reports.report_figures import figures
from studies.reports.view import flag_words, main_quantities
from studies.sweeps.sweep import OFFSET, RESOLUTION

# 2: converged values and their error bars, a sentence about each law
# 3: an error bar without the mesh's part judges nothing
# 4: figures of residuals have the error bar as a band
REPORT_VERSION = 4
DRIFT_LIMIT = 0.01  # of the initial energy: beyond it a run does not keep its books, and is marked


# Endings of the names of audit numbers that are printed in per cent.
SHARES = ("drift", "error", "share", "fraction")

RULES = (
    "The value of a resolution is the mean over its sub-cell offsets, the number behind ± their scatter: half the "
    "range of two or three, the standard deviation of more. The order is observed over the three finest resolutions "
    "(Celik et al. 2008, J. Fluids Eng. 130, 078001). GCI is the grid convergence index over the finest value, factor "
    f"of safety {SAFETY:g}; two resolutions show no order, so order {ASSUMED_ORDER:g} and a factor of "
    f"{SAFETY_UNOBSERVED:g} are taken. Only where the verdict is converging, with an order from "
    f"{ORDERS[0]:g} to {ORDERS[1]:g} and differences above the scatter, is there an extrapolated "
    "number, and it is the value. (One offset has no scatter; what the measurement says that one "
    "run cannot see stands for it.) Elsewhere the value is that of the finest resolution, "
    "and the mesh part of its error bar the largest of three: the range of the three finest, the "
    "scatter behind the finest difference, and that difference over its ratio of cells to the "
    f"power {ORDERS[0]:g} less one, times {SAFETY:g}, or times {SAFETY_UNOBSERVED:g} where the "
    f"observed order is below {ORDERS[0]:g} (the factors of Eça and Hoekstra 2014, J. Comput. "
    "Phys. 262, 104). Of three resolutions the mesh part also reaches, in either case, the farthest limit of any power "
    f"law of an order from {ORDERS[0]:g} to {ORDERS[1]:g} that passes each value within its scatter. Where runs found "
    "nothing to measure and others did, nothing is extrapolated and the mesh part is unknown."
)

UNJUDGED = (
    "how far that is off, only several resolutions can say, so nothing is called inside or outside "
    "of it."
)

Document = dict[str, Any]


def document(dataset: xr.Dataset, comparison: Comparison) -> Document:
    """Everything that the report says, as plain objects in SI."""
    runs, points = list(_runs(dataset)), points_of(dataset)
    return {
        "report_version": REPORT_VERSION,
        "title": dataset.attrs["title"],
        "scenario": {"name": dataset.attrs["scenario"], "title": dataset.attrs["scenario_title"]},
        "statement": comparison.statement,
        "overview": _overview(runs),
        "mesh": _mesh(dataset),
        "axes": [_axis(dataset, name) for name in axes_of(points)],
        "refinements": [_axis(dataset, name) for name in refinements_of(dataset)],
        "coordinates": [_axis(dataset, name) for name in axes_of(dataset)],
        "fixed": list(_fixed(dataset)),
        "quantities": list(_quantities(dataset)),
        "extremes": list(_extremes(points)),
        "figures": [figure.as_json() for figure in figures(dataset, comparison)],
        "convergence": _convergence(dataset) if refinements_of(dataset) else None,
        **{key: value for key, value in comparison.as_json().items() if key != "statement"},
        "runs": runs,
        "audit": list(_audit(dataset)),
        "laws": list(_laws(dataset)),
        "materials": _materials(dataset),
        "provenance": _provenance(dataset),
    }


def as_json(report: Document) -> str:
    """The twin as text; a number that is none is null."""
    return json.dumps(report, ensure_ascii=False, allow_nan=False, indent=1) + "\n"


# ---- what the document says ----------------------------------------------------------------------


def _overview(runs: Sequence[Document]) -> Document:
    states = Counter(run["state"] for run in runs)
    return {
        "runs": len(runs),
        "states": [{"state": state, "runs": states[state]} for state in STATES if states[state]],
        "flagged": sum(bool(run["flags"]) for run in runs),
        "without_value": sum(run["state"] == "succeeded" and not run["has_value"] for run in runs),
    }


def _mesh(dataset: xr.Dataset) -> str:
    """What the error bars know of the mesh, in words."""
    several = refinements_of(dataset)
    if not several:
        return (
            "Every point is one run on one mesh. Its error bar has a part for what a single run "
            f"cannot see below the size of a cell, and none for the mesh as a whole: {UNJUDGED}"
        )
    counts = {name: dataset.sizes[name] for name in several}
    words = [f"{counts[RESOLUTION]} resolutions"] if RESOLUTION in counts else []
    words += [f"{counts[OFFSET]} sub-cell offsets"] if OFFSET in counts else []
    beside = "scatter over offsets and what the measurement states beside"
    if RESOLUTION in counts:
        value = (
            "extrapolated to cells of no size where the verdict is converging, and else that of "
            "the finest resolution"
        )
        bar = f"mesh error, {beside}, as root of the sum of their squares."
    else:
        value = "the mean over offsets"
        bar = (
            f"{beside}, as root of the sum of their squares, and has no part for the mesh as a "
            f"whole: {UNJUDGED}"
        )
    return (
        f"Every point was computed with {' and '.join(words)}. Laws and observations are compared "
        f"with one value a point: {value}. Its error bar joins {bar}"
    )


def _convergence(dataset: xr.Dataset) -> Document:
    """Values by resolution, orders, error bars and verdicts of each quantity at each point."""
    main, places = main_quantities(dataset), places_of(points_of(dataset))
    quantities = [
        {
            "quantity": name,
            "words": name.replace("_", " "),
            "unit": dataset[name].attrs["units"],
            "main": name in main,
            "points": [_refined(one, places) for one in refined(dataset, name)],
        }
        for name in str(dataset.attrs["quantities"]).split()
    ]
    for one in quantities:
        counts = Counter(point["verdict"] for point in one["points"])
        one["verdicts"] = [
            {"verdict": verdict, "points": counts[verdict]}
            for verdict in VERDICTS
            if counts[verdict]
        ]
    several = RESOLUTION in refinements_of(dataset)
    resolutions = dataset[RESOLUTION].values.tolist() if several else [None]
    return {"rules": RULES, "resolutions": resolutions, "quantities": quantities}


def _refined(one: Refined, places: Sequence[Mapping[str, float | str]]) -> Document:
    numbers = ("value", "uncertainty", "mesh", "offsets", "measurement")
    judged = ("order", "extrapolated", "gci")
    return {
        "at": places[one.number],
        "verdict": one.verdict,
        "reason": one.reason,
        **{name: _finite(getattr(one, name)) for name in (*numbers, *judged)},
        "levels": [
            {
                "spacing": level.spacing,
                "value": _finite(level.value),
                "scatter": _finite(level.scatter),
                "values": level.values,
                "runs": level.runs,
            }
            for level in reversed(one.levels)
        ],
    }


def _axis(dataset: xr.Dataset, name: str) -> Document:
    axis = dataset[name]
    values = list(dict.fromkeys(plain(value) for value in axis.values))
    return {
        "name": name,
        "unit": axis.attrs.get("units"),
        "meaning": axis.attrs["long_name"],
        "values": values,
    }


def _fixed(dataset: xr.Dataset) -> Iterator[Document]:
    """Parameters that all runs share."""
    known = json.loads(dataset.attrs["vocabulary"])["parameters"]
    for parameter, (_, unit, meaning) in known.items():
        name = parameter.replace(".", "_")
        if name in dataset and not dataset[name].dims:
            value = _finite(plain(dataset[name].item()))
            if value not in (None, ""):
                yield {"name": parameter, "value": value, "unit": unit, "meaning": meaning}


def _quantities(dataset: xr.Dataset) -> Iterator[Document]:
    main = main_quantities(dataset)
    for name in str(dataset.attrs["quantities"]).split():
        yield {
            "name": name,
            "words": name.replace("_", " "),
            "unit": dataset[name].attrs["units"],
            "meaning": dataset[name].attrs["long_name"],
            "main": name in main,
        }


def _extremes(dataset: xr.Dataset) -> Iterator[Document]:
    """Smallest and largest value of each main quantity, and where."""
    places = places_of(dataset)
    for name in main_quantities(dataset):
        values = dataset[name].values.ravel()
        if np.isfinite(values).any():
            low, high = int(np.nanargmin(values)), int(np.nanargmax(values))
            yield {
                "quantity": name.replace("_", " "),
                "unit": dataset[name].attrs["units"],
                "smallest": float(values[low]),
                "smallest_at": places[low],
                "largest": float(values[high]),
                "largest_at": places[high],
            }


def _runs(dataset: xr.Dataset) -> Iterator[Document]:
    """Each run, with the values of its cell by the names of the cube's variables."""
    names = _run_variables(dataset)
    columns = {name: _column(dataset, name) for name in names}
    words = {
        name: flag_words(dataset, name) for name in map(str, dataset) if name.endswith("_flags")
    }
    texts = {
        name: dataset[name].values.ravel()
        for name in ("run_id", "run_reason", "run_failure", "stop_reason")
    }
    states = dataset.run_state.values.ravel()
    main = main_quantities(dataset)
    for number, place in enumerate(places_of(dataset)):
        values = {name: _finite(float(column[number])) for name, column in columns.items()}
        yield {
            "number": number,
            "id": str(texts["run_id"][number]),
            "at": place,
            "state": STATES[states[number]],
            "reason": str(texts["run_reason"][number]),
            "failure": str(texts["run_failure"][number]),
            "stop": str(texts["stop_reason"][number]),
            "flags": _flags(words, number),
            "has_value": any(values[name] is not None for name in main),
            "values": values,
            "ratios": _ratios(values, main),
        }


def _run_variables(dataset: xr.Dataset) -> list[str]:
    """Numbers that a run has one of: quantities, uncertainties, audit, time, diameter."""
    axes = set(axes_of(dataset))
    return [
        str(name)
        for name, array in dataset.variables.items()
        if array.dtype.kind == "f"
        and name not in axes
        and (array.dims == dataset.run_state.dims or name == "equivalent_diameter")
    ]


def _column(dataset: xr.Dataset, name: str) -> np.ndarray:
    return (
        dataset[name]
        .broadcast_like(dataset.run_state)
        .transpose(*dataset.run_state.dims)
        .values.ravel()
    )


def _flags(words: Mapping[str, Sequence[tuple[str, ...]]], number: int) -> list[str]:
    """All flags of a run, those of a quantity with its name."""
    found = []
    for name, flags in words.items():
        quantity = name.removesuffix("_flags")
        prefix = "" if quantity == "run" else f"{quantity.replace('_', ' ')}: "
        found += [f"{prefix}{flag.replace('_', ' ')}" for flag in flags[number]]
    return found


def _ratios(values: Mapping[str, float | None], names: Sequence[str]) -> dict[str, float | None]:
    """Quantities over the projectile's diameter."""
    diameter = values.get("equivalent_diameter")
    return {name: _over(values[name], diameter) for name in names}


def _over(value: float | None, diameter: float | None) -> float | None:
    return None if value is None or diameter is None else value / diameter


def _audit(dataset: xr.Dataset) -> Iterator[Document]:
    """For each number of the audit: its range, and the run that is farthest from zero."""
    places = places_of(dataset)
    for variable in NUMBERS:
        if variable.name in dataset and np.isfinite(dataset[variable.name]).any():
            values = dataset[variable.name].values.ravel()
            worst = int(np.nanargmax(np.abs(values)))
            limit = DRIFT_LIMIT if variable.name.endswith("energy_drift") else None
            yield {
                "variable": variable.name,
                "words": variable.name.removeprefix("audit_").replace("_", " "),
                "meaning": variable.meaning,
                "unit": variable.unit,
                "kind": _audit_kind(variable.name, variable.unit),
                "smallest": float(np.nanmin(values)),
                "median": float(np.nanmedian(values)),
                "largest": float(np.nanmax(values)),
                "farthest_at": places[worst],
                "limit": limit,
                "over_limit": None if limit is None else int((np.abs(values) > limit).sum()),
            }


def _audit_kind(name: str, unit: str | None) -> str:
    return "share" if unit == "1" and name.endswith(SHARES) else "plain"


def _laws(dataset: xr.Dataset) -> Iterator[Document]:
    """Each law once, with the constants that it was evaluated with."""
    for name in str(dataset.attrs["quantities"]).split():
        if f"{name}_law" not in dataset:
            continue
        rows = range(dataset.sizes[f"{name}_law"])
        keys = ("name", "title", "equation", "source", "range", "confidence", "variant")
        words = {key: [str(word) for word in dataset[f"{name}_law_{key}"].values] for key in keys}
        for law in dict.fromkeys(words["name"]):
            mine = [row for row in rows if words["name"][row] == law]
            yield {
                **{key: words[key][mine[0]] for key in keys[:-1]},
                "quantity": name.replace("_", " "),
                "variants": [words["variant"][row] for row in mine if words["variant"][row]],
                "reasons": _reasons(dataset, name, mine),
            }


def _reasons(dataset: xr.Dataset, name: str, rows: Sequence[int]) -> list[Document]:
    """Why the law is out of range or has no answer, with the number of answers concerned."""
    found = Counter(
        str(reason)
        for reason in dataset[f"{name}_by_law_reason"]
        .isel({f"{name}_law": list(rows)})
        .values.ravel()
        if reason
    )
    return [{"reason": reason, "answers": count} for reason, count in found.most_common()]


def _materials(dataset: xr.Dataset) -> list[Document]:
    known = json.loads(dataset.attrs["materials"])
    return [
        {
            "name": name,
            "title": material["title"],
            "numbers": [{"path": path, **number} for path, number in material["numbers"].items()],
        }
        for name, material in known.items()
    ]


def _provenance(dataset: xr.Dataset) -> Document:
    attributes = dataset.attrs
    return {
        "cube": {
            name: attributes[name]
            for name in (
                "Conventions",
                "institution",
                "source",
                "date_created",
                "undeclared_numbers",
            )
        },
        "schema_version": int(attributes["schema_version"]),
        "software": json.loads(attributes["software"]),
        "sweep": json.loads(attributes["sweep"]),
    }


def _finite(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value
