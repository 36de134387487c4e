"""Parts of a cube, and the cube of a sweep that is still running.

``excerpt`` takes some variables of a cube at some values of its axes; what belongs to a variable, its
uncertainty and flags and the state of its runs, comes along. ``write_partial`` makes the cube of what
is there: a run that has not ended is ``pending`` or ``running``, its numbers are NaN.
"""

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from studies import cube
from studies.atomic import write_text
from studies.catalogue import Catalogue
from studies.errors import Finding, InvalidInput
from studies.nearest import nearest_cure, shown
from studies.publish import outcome_from_json
from studies.quantities import parse_quantity, readable
from studies.variables import variable_name

MOST_VALUES = 1_000_000  # of an excerpt; the whole cube is a file of its own
EQUAL = 1e-9  # relative; an axis holds 12 significant digits
BETWEEN = ".."  # "2 km/s..4 km/s", either end may be left out
SHOWN_VALUES = 8  # of an axis, in the limit of a finding


def write_partial(
    document: Mapping[str, Any],
    outcomes: Mapping[str, Mapping[str, Any]],
    file: Path,
    *,
    state: str,
    catalogue: Catalogue | None = None,
) -> Path:
    """The cube of a sweep as far as it is; ``state`` says so in its attributes."""
    from studies.sweep import ACCEPTED, Sweep

    sweep = Sweep.parse(document, ACCEPTED)
    results = {run_id: outcome_from_json(plain) for run_id, plain in outcomes.items()}
    dataset = cube.build(sweep, results, catalogue)
    return cube.write(marked_as_partial(dataset, state), file)


def marked_as_partial(dataset: xr.Dataset, state: str) -> xr.Dataset:
    """A cube that says of itself that it is not complete."""
    comment = f"Not complete: the sweep was {state}. {dataset.attrs['comment']}"
    return dataset.assign_attrs(sweep_state=state, comment=comment)


def excerpt(
    dataset: xr.Dataset, variables: Sequence[str], at: Mapping[str, Sequence[str]]
) -> xr.Dataset:
    """Some variables (none named: what was measured) at some values of the axes.

    Of an axis either single values are given, with or without a unit (SI without), or one range
    "from..to", both ends included. An axis of which one value is taken is no dimension any more.
    Raises InvalidInput with every finding.
    """
    findings: list[Finding] = []
    wanted = _wanted(dataset, variables, findings)
    places: dict[str, np.ndarray] = {}
    single: list[str] = []
    for name, texts in at.items():
        axis = _axis(dataset, name, findings)
        if axis is None:
            continue
        try:
            chosen = _chosen(dataset[axis], name, texts)
        except InvalidInput as error:
            findings.extend(error.findings)
            continue
        dim = str(dataset[axis].dims[0])
        places[dim] = np.intersect1d(places.get(dim, chosen), chosen)
        if not len(places[dim]):
            limit = "values that one run has together"
            findings.append(Finding(name, shown(texts[0]), limit, "ask for one of them alone"))
        if len(texts) == 1 and BETWEEN not in texts[0] and dim == axis:
            single.append(dim)
    if findings:
        raise InvalidInput(findings)
    part = dataset[wanted].isel(places)
    _check_size(part)
    return part.squeeze([dim for dim in single if dim in part.dims])


def as_json(dataset: xr.Dataset) -> dict[str, Any]:
    """A dataset as plain objects: dimensions, coordinates and variables; NaN is null."""
    return {
        "title": dataset.attrs.get("title", ""),
        "sweep_state": dataset.attrs.get("sweep_state"),
        "dims": {str(name): size for name, size in dataset.sizes.items()},
        "coords": {str(name): _plain(dataset[name]) for name in dataset.coords},
        "variables": {str(name): _plain(dataset[name]) for name in dataset.data_vars},
    }


def write_part(
    source: Path, variables: Sequence[str], at: Mapping[str, Sequence[str]], file: Path
) -> Path:
    """An excerpt of the cube in a file, as JSON or as NetCDF: by the ending of its name."""
    with xr.open_dataset(source) as dataset:
        part = excerpt(dataset, variables, at)
        if file.suffix == ".nc":
            return cube.write(part, file)
        return write_text(file, json.dumps(as_json(part), allow_nan=False))


# ---- variables -----------------------------------------------------------------------------------


def _wanted(dataset: xr.Dataset, variables: Sequence[str], findings: list[Finding]) -> list[str]:
    names = list(variables) or dataset.attrs["quantities"].split()
    unknown = [name for name in names if name not in dataset.data_vars]
    for name in unknown:
        limit = "a variable of this cube"
        cure = nearest_cure(name, map(str, dataset.data_vars))
        findings.append(Finding("variable", shown(name), limit, cure))
    known = [name for name in names if name not in unknown]
    companions = [
        other
        for name in known
        for other in dataset[name].attrs.get("ancillary_variables", "").split()
        if other in dataset.data_vars
    ]
    return list(dict.fromkeys([*known, *companions]))


def _check_size(part: xr.Dataset) -> None:
    values = sum(array.size for array in part.data_vars.values())
    if values > MOST_VALUES:
        cure = "ask for fewer variables or a part of an axis, or fetch cube.nc"
        limit = f"at most {MOST_VALUES} values"
        raise InvalidInput([Finding("variable", f"{values} values", limit, cure)])


# ---- axes ----------------------------------------------------------------------------------------


def _axis(dataset: xr.Dataset, name: str, findings: list[Finding]) -> str | None:
    """The coordinate that a user means by the name of a parameter."""
    axes = [*dataset.attrs["axes"].split(), *dataset.attrs["refinements"].split()]
    if "run" in dataset.coords:
        axes.append("run")
    axes = [axis for axis in axes if dataset[axis].ndim == 1]
    if variable_name(name) in axes:
        return variable_name(name)
    cure = nearest_cure(name, axes)
    findings.append(Finding(name, "not an axis", "an axis of this cube", cure))
    return None


def _chosen(axis: xr.DataArray, name: str, texts: Sequence[str]) -> np.ndarray:
    """Places on an axis; raises InvalidInput where it has no such value."""
    if any(BETWEEN in text for text in texts) and axis.dtype.kind in "fiu":
        if len(texts) > 1:
            limit, cure = "one range, or single values", "ask twice, or leave the range out"
            raise InvalidInput([Finding(name, shown(texts[0]), limit, cure)])
        return _within(axis, name, texts[0])
    found = [_place(axis, name, text) for text in texts]
    return np.unique(np.concatenate(found))


def _within(axis: xr.DataArray, name: str, text: str) -> np.ndarray:
    low, _, high = text.partition(BETWEEN)
    first = _number(axis, name, low) if low.strip() else -math.inf
    last = _number(axis, name, high) if high.strip() else math.inf
    slack = EQUAL * np.abs(axis.values)
    inside = (axis.values >= first - slack) & (axis.values <= last + slack)
    if not inside.any():
        raise _no_such(axis, name, text)
    return np.flatnonzero(inside)


def _place(axis: xr.DataArray, name: str, text: str) -> np.ndarray:
    """Where an axis has a value; along the runs of a zip it may be there several times."""
    if axis.dtype.kind in "fiu":
        value = _number(axis, name, text)
        found = np.flatnonzero(np.isclose(axis.values.astype(float), value, rtol=EQUAL, atol=0.0))
    else:
        found = np.flatnonzero(axis.values.astype(str) == text)
    if not len(found):
        raise _no_such(axis, name, text)
    return found


def _number(axis: xr.DataArray, name: str, text: str) -> float:
    """A value in SI: a plain number is one, another unit is named."""
    unit = axis.attrs.get("units", "1")
    try:
        value = float(text)
    except ValueError:
        return float(parse_quantity(text.strip(), unit, name))
    if not math.isfinite(value):
        raise _no_such(axis, name, text)
    return value


def _no_such(axis: xr.DataArray, name: str, text: str) -> InvalidInput:
    unit = axis.attrs.get("units")
    values = [readable(float(v), unit) if unit else str(v) for v in np.unique(axis.values)]
    listed = ", ".join(values[:SHOWN_VALUES]) + (", ..." if len(values) > SHOWN_VALUES else "")
    cure = f"take one of these, or a range such as '{values[0]}{BETWEEN}{values[-1]}'"
    return InvalidInput([Finding(name, shown(text), f"a value of this axis: {listed}", cure)])


# ---- plain objects -------------------------------------------------------------------------------


def _plain(array: xr.DataArray) -> dict[str, Any]:
    about: dict[str, Any] = {"dims": [str(dim) for dim in array.dims]}
    for key, word in (("units", "unit"), ("long_name", "meaning"), ("flag_meanings", "words")):
        if key in array.attrs:
            about[word] = array.attrs[key]
    if "words" in about:
        about["words"] = about["words"].split()
    return {**about, "values": _finite(array.values.tolist())}


def _finite(value: Any) -> Any:
    if isinstance(value, Iterable) and not isinstance(value, str):
        return [_finite(one) for one in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
