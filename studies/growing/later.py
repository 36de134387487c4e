"""The sweep that gives a later end to runs that were still growing at their latest one."""

import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from studies.cubes.opening import whole_cube
from studies.cubes.reading import still_growing
from studies.quantities.findings import refusal
from studies.quantities.parameters import Value
from studies.quantities.units import round_quantity
from studies.sweeps.reading import ACCEPTED, END
from studies.sweeps.sweep import Sweep

LATER = 2.0  # times the latest end


def with_later_ends(cube_or_folder: Path) -> tuple[Sweep, int]:
    """The sweep of a cube, where each point with a run that was still growing ends twice as late; and their number.

    All runs of such a point, on each grid, get the end of the latest. Runs of other points are those of the cube.
    Raises InvalidInput for a search, an axis of ends, and runs of another version, whose ids are others.
    """
    dataset = whole_cube(cube_or_folder)
    sweep, growing = Sweep.parse(json.loads(dataset.attrs["sweep"]), ACCEPTED), still_growing(dataset)
    if "search" in dataset.attrs or any(axis.name == END for axis in sweep.axes):
        limit = "a sweep without a search and without an axis end_time"
        raise refusal("FOLDER", sweep.name, limit, "give later ends in its document, and sweep again")
    ends: dict[tuple[Value, ...], tuple[Mapping[str, Value], float]] = {}
    seen = set()
    for point in sweep.runs():
        if point.run.id in growing:
            seen.add(point.run.id)
            at = {axis.name: point.coordinates[axis.name] for axis in sweep.axes}
            end = round_quantity(LATER * float(point.run.parameters[END] or 0.0))
            key = tuple(at.values())
            ends[key] = at, max(end, ends.get(key, (at, 0.0))[1])
    if seen != growing:
        limit = "runs of this version of whipple"
        raise refusal("FOLDER", f"{len(growing - seen)} others", limit, "sweep again into another folder")
    kept = [(at, end) for at, end in sweep.ends if tuple(at[axis.name] for axis in sweep.axes) not in ends]
    return replace(sweep, ends=(*kept, *ends.values())), len(ends)
