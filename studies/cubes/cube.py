"""The cube: what a sweep computed, labelled, in one xarray Dataset and one NetCDF-4 file.

Dimensions are the axes of the sweep (grid), or one dimension ``run`` with the axes as coordinates
along it (zip). A sweep that names several resolutions or offsets has them as further dimensions,
``cells_per_diameter`` and ``offset``; what converges over them is ``{quantity}_converged`` and its
companions, over the axes alone. Every run keeps its cell: one that has no result is NaN, with
``run_state`` and ``run_reason`` saying why. The laws are evaluated here, so that ``xarray.open_dataset("cube.nc")``
alone redoes the report. What may be in it, and what each variable means: :mod:`studies.cubes.variables`.
"""

import json
from collections.abc import Iterable, Iterator, Mapping
from datetime import UTC, datetime
from math import prod
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from studies.cubes.catalogue import Catalogue, catalogue_of
from studies.cubes.columns import Mask, all_columns, undeclared
from studies.cubes.layout import Layout, MissingResult, lay_out
from studies.cubes.variables import (
    SCHEMA_VERSION,
    SchemaError,
    Variable,
    Vocabulary,
    schema,
    variable_name,
    vocabulary_as_json,
    vocabulary_from_json,
)
from studies.values.atomic import write_atomically

__all__ = ["MissingResult", "build", "validate", "write"]

CHUNK_VALUES = 1_000_000  # 8 MB: a whole variable of most cubes, so that one read gets it
ONCE_A_RUN = ("started", "seconds", "threads")  # provenance that is no version of anything


def build(sweep: Any, results: Mapping[str, Any], catalogue: Catalogue | None = None) -> xr.Dataset:
    """The cube of a sweep; ``results`` has a ``RunResult`` or an :class:`Outcome` by run id."""
    catalogue = catalogue or catalogue_of(sweep)
    layout = lay_out(sweep, results, catalogue.shot_of)
    words = _vocabulary(layout, catalogue)
    declared = schema(words)
    dataset = xr.Dataset(
        {
            name: _labelled(name, values, declared)
            for name, values in all_columns(layout, words, catalogue)
        }
    )
    dataset = dataset.set_coords(
        [name for name in dataset if _is_coordinate(dataset[name], layout)]
    )
    dataset.attrs = _about(sweep, layout, words, catalogue)
    return validate(_ascending(dataset))


def validate(dataset: xr.Dataset) -> xr.Dataset:
    """The dataset itself, when each variable is as declared; raises ``SchemaError``."""
    words = vocabulary_from_json(json.loads(dataset.attrs["vocabulary"]))
    declared = schema(words)
    wrong = [
        complaint
        for name, array in dataset.variables.items()
        for complaint in _complaints(str(name), array, declared.get(str(name)), words)
    ]
    if wrong:
        raise SchemaError("\n".join(wrong))
    return dataset


def write(dataset: xr.Dataset, path: Path) -> Path:
    """Write a cube as NetCDF-4; the file is there whole or not at all.

    A half-written NetCDF-4 file opens and reads as NaN, so nothing is written in place.
    """
    encoding = {
        str(name): _encoding(str(name), array, dataset) for name, array in dataset.variables.items()
    }
    return write_atomically(
        path,
        lambda file: dataset.to_netcdf(
            file, engine="netcdf4", format="NETCDF4", encoding=encoding, unlimited_dims=()
        ),
    )


# ---- words ---------------------------------------------------------------------------------------


def _vocabulary(layout: Layout, catalogue: Catalogue) -> Vocabulary:
    parts: dict[str, set[str]] = {name: set() for name in catalogue.quantities}
    for cell in layout.cells:
        for name in parts.keys() & cell.measurements.keys():
            parts[name].update(cell.measurements[name].parts)
    return Vocabulary(
        axes=layout.dims,
        refinements=_names(layout.refinements),
        quantities=catalogue.quantities,
        parameters=catalogue.parameters,
        parts={name: tuple(sorted(found)) for name, found in parts.items() if found},
    )


# ---- labels --------------------------------------------------------------------------------------


def _labelled(name: str, values: Any, declared: Mapping[str, Variable]) -> xr.Variable:
    """A column with the dimensions and attributes that its name declares."""
    if name not in declared:
        raise SchemaError(f"{name} is not declared in studies.cubes.variables")
    variable = declared[name]
    mask = values if isinstance(values, Mask) else None
    array = np.asarray(mask.values if mask else values)
    attributes: dict[str, Any] = {**variable.attributes(), **_flag_attributes(variable, mask)}
    if {f"{name}_flags", f"{name}_uncertainty"} <= declared.keys():
        attributes["ancillary_variables"] = f"{name}_uncertainty {name}_flags run_state"
    return xr.Variable(variable.dims[: array.ndim], array, attributes)


def _flag_attributes(variable: Variable, mask: Mask | None) -> dict[str, Any]:
    if mask is not None:
        bits = np.array([1 << place for place in range(len(mask.meanings))], np.int32)
        return {"flag_masks": bits, "flag_meanings": " ".join(mask.meanings)}
    if variable.kind == "flag":
        return {
            "flag_values": np.arange(len(variable.words), dtype=np.int8),
            "flag_meanings": " ".join(variable.words),
        }
    return {}


def _is_coordinate(array: xr.DataArray, layout: Layout) -> bool:
    """Axes are coordinates; so is what labels a dimension, and the words about each law."""
    axes = {*_names(layout.axes), *_names(layout.refinements)}
    about_laws = len(array.dims) == 1 and str(array.dims[0]).endswith("_law")
    return str(array.name) in axes or array.dims == (array.name,) or about_laws


def _ascending(dataset: xr.Dataset) -> xr.Dataset:
    """Numeric axes ascend, as CF asks of a coordinate; a sweep may list them in any order."""
    axes = [dim for dim in dataset.dims if dim in dataset.coords and dataset[dim].dtype.kind == "f"]
    return dataset.sortby(axes) if axes else dataset


def _about(sweep: Any, layout: Layout, words: Vocabulary, catalogue: Catalogue) -> dict[str, Any]:
    """Where the cube comes from: CF's words for people, and JSON for programs."""
    now = datetime.now(UTC).isoformat(timespec="seconds")
    versions = _versions(layout)
    document = sweep.document()
    title = document.get("title") or document.get("name") or catalogue.title
    return {
        "Conventions": "CF-1.11",
        "title": title,
        "institution": document.get("institution") or "not stated",
        "source": f"{catalogue.title}; material point method, whipple {_spoken(versions)}".strip(),
        "history": f"{now} cube assembled from {len(layout.cells)} runs",
        "references": "; ".join(_references(catalogue)) or "none",
        "comment": "A cell is a run. NaN: no result, run_state and run_reason say why.",
        "date_created": now,
        "schema_version": SCHEMA_VERSION,
        "scenario": document["scenario"],
        "scenario_title": catalogue.title,
        "axes": " ".join(_names(layout.axes)),
        "refinements": " ".join(_names(layout.refinements)),
        "quantities": " ".join(words.quantities),
        "undeclared_numbers": " ".join(undeclared(layout)),
        "sweep": _json(document),
        "materials": _json(catalogue.materials),
        "software": _json(versions),
        "measurement_versions": _json(_definitions(layout)),
        "vocabulary": _json(vocabulary_as_json(words)),
    }


def _names(axes: Iterable[Any]) -> tuple[str, ...]:
    return tuple(variable_name(axis.name) for axis in axes)


def _versions(layout: Layout) -> dict[str, list[str]]:
    """Every version that a run of this cube was computed with, by what it is a version of."""
    found: dict[str, set[str]] = {}
    for cell in layout.cells:
        for name, value in cell.provenance.items():
            if name not in ONCE_A_RUN:
                found.setdefault(name, set()).add(str(value))
    return {name: sorted(values) for name, values in sorted(found.items())}


def _definitions(layout: Layout) -> dict[str, list[int]]:
    """Versions of the definitions that each quantity of this cube was measured with; more than one: mixed."""
    found: dict[str, set[int]] = {}
    for cell in layout.cells:
        for name, measured in cell.measurements.items():
            found.setdefault(name, set()).add(measured.version)
    return {name: sorted(versions) for name, versions in sorted(found.items())}


def _spoken(versions: Mapping[str, list[str]]) -> str:
    return ", ".join(f"{name} {'/'.join(values)}" for name, values in versions.items())


def _references(catalogue: Catalogue) -> list[str]:
    """Sources of the laws of this cube's quantities, each once."""
    laws = [law for law in catalogue.laws if law.quantity in catalogue.quantities]
    return list(dict.fromkeys(law.source for law in laws))


def _json(plain: Any) -> str:
    return json.dumps(plain, ensure_ascii=False, sort_keys=True)


# ---- checks and files ----------------------------------------------------------------------------


def _complaints(
    name: str, array: xr.Variable, variable: Variable | None, words: Vocabulary
) -> Iterator[str]:
    if variable is None:
        yield f"{name} is not declared in studies.cubes.variables"
        return
    if array.dims not in _allowed_dims(variable, words):
        yield f"{name} has the dimensions {array.dims}; declared: {variable.dims}"
    if array.attrs.get("units") != variable.unit:
        yield f"{name} is in {array.attrs.get('units')!r}; declared: {variable.unit!r}"
    if (array.dtype.kind in "OUT") != (variable.kind == "text"):
        yield f"{name} holds {array.dtype}; declared: {variable.kind}"


def _allowed_dims(variable: Variable, words: Vocabulary) -> tuple[tuple[str, ...], ...]:
    """What is the same for all runs is a scalar; what is the same for all runs of a point, by point."""
    by_run = variable.dims == words.axes
    return (variable.dims, (), words.points) if by_run else (variable.dims, ())


def _encoding(name: str, array: xr.Variable, dataset: xr.Dataset) -> dict[str, Any]:
    """float64 as it is, deflated lightly; coordinates and flags have no fill value (CF)."""
    if array.dtype.kind in "OUT":
        return {}
    number = array.dtype.kind == "f" and name not in dataset.coords
    fill = {"_FillValue": np.nan if number else None}
    if not array.dims:
        return fill
    return {
        **fill,
        "zlib": True,
        "complevel": 1,
        "shuffle": True,
        "chunksizes": _chunks(array.shape),
    }


def _chunks(shape: tuple[int, ...]) -> tuple[int, ...]:
    """The whole variable, or as many rows of its first dimension as make a chunk."""
    row = max(1, prod(shape[1:]))
    return (min(shape[0], max(1, CHUNK_VALUES // row)), *shape[1:])
