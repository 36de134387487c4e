"""whipple against all published shots that ship: computed once, kept in studies/observations/compared.json, from which
reports take bias and scatter too, and printed as a page.

Bias and scatter are those of simulation / observation - 1: the interval of its mean, and its standard deviation.
"""

import json
import math
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

from docs.pages import in_markdown, keep, plots, table
from solver import PHYSICS_VERSION
from studies import laws, measurements, observations, scenarios
from studies.answers.answer import ask
from studies.observations import written
from studies.observations.compared import FEWEST, STORED, StoredShot, bias_and_scatter, ratio, stored
from studies.quantities.display import MESH_UNKNOWN, NONE, decimals, display_of, signed, with_bar
from studies.quantities.least_squares import CONFIDENCE
from studies.quantities.parameters import declared
from studies.sweeps.reading import published_shots

COMMAND = "python -m docs.pages compute shots"

# Scenario and grids of each table: a bar of ten diameters takes five minutes on three grids, 15 s on one.
ONE_GRID: Mapping[str, Any] = {"resolution": 16}
TABLES: Mapping[str, tuple[str, Mapping[str, Any]]] = {
    "taylor-bars-copper-ofhc": ("taylor_bar", ONE_GRID),
    "taylor-bars-copper-etp": ("taylor_bar", ONE_GRID),
    "taylor-bars-al-6061-t6": ("taylor_bar", ONE_GRID),
    "taylor-bars-steel-4340": ("taylor_bar", ONE_GRID),
    "craters": ("thick_plate", ONE_GRID),
    "holes": ("thin_plate", {"resolution": [16, 24, 36], "offsets": 3}),
}
# The published blocks were as good as without end: an absorbing one is within 0.2 % of that (absorbing-block).
FIXED = {"craters": {"edges": "absorbing", "particles_per_cell": 2}}
TITLES = {
    "taylor-bars-copper-ofhc": "Taylor bars, OFHC copper",
    "taylor-bars-copper-etp": "Taylor bars, ETP copper",
    "taylor-bars-al-6061-t6": "Taylor bars, aluminium 6061-T6",
    "taylor-bars-steel-4340": "Taylor bars, steel 4340",
    "craters": "Craters, copper and aluminium",
    "holes": "Holes, aluminium on aluminium and on copper",
}
DOUBTFUL = "contradicts"  # in the note of a shot that is faster than another of its series, and shortened less

Rows = Sequence[StoredShot]


# ---- computed ------------------------------------------------------------------------------------


def compute(directory: Path | None = None) -> None:
    """Every shot of every table, into ``studies/observations/compared.json``; a directory that is kept resumes."""
    with tempfile.TemporaryDirectory() as temporary:
        place = directory or Path(temporary)
        quantities = {shot.quantity for name in TABLES for shot in published(name)}
        document = {
            "command": COMMAND,
            "version": version("whipple"),
            "physics_version": PHYSICS_VERSION,
            "measurements": {name: measurements.load(name).version for name in sorted(quantities)},
            "grids": {name: grids for name, (_, grids) in TABLES.items()},
            "shots": [row for name in TABLES for row in computed(name, place / name)],
        }
    keep(document, STORED)


def published(name: str) -> tuple[observations.Observation, ...]:
    """The shots of a table."""
    scenario, _ = TABLES[name]
    return published_shots(name, scenario)


def sweep_of(name: str, shots: Sequence[observations.Observation]) -> dict[str, Any]:
    """A sweep with a point at the parameters of each shot, and the table beside it."""
    scenario, grids = TABLES[name]
    units = {each.name: each.unit for each in declared(scenarios.load(scenario).parameters).values()}
    places = list(dict.fromkeys(tuple(sorted(shot.parameters.items())) for shot in shots))
    axes = {axis: [written(dict(place)[axis], units[axis]) for place in places] for axis, _ in places[0]}
    return {
        "name": name,
        "scenario": scenario,
        "fixed": FIXED.get(name, {}),
        "axes": axes,
        "combine": "zip",
        **grids,
        "observations": name,
    }


def computed(
    name: str, folder: Path, shots: Sequence[observations.Observation] | None = None
) -> Iterator[dict[str, Any]]:
    """A row for each shot of a table: as published, with the simulation at its parameters; all of them by default.

    Raises ValueError where the folder has results of an earlier definition.
    """
    import whipple
    from studies.cubes import reading
    from studies.cubes import variables as cubes
    from studies.cubes.opening import whole_cube
    from studies.cubes.points import places_of, points_of
    from studies.reports.matched import matched_observations

    all_shots = published(name)
    wanted = all_shots if shots is None else shots
    yield from (_row(name, shot) for shot in wanted if shot.value is None)
    document = sweep_of(name, [shot for shot in wanted if shot.value is not None])
    cube = whole_cube(whipple.run_sweep(document, folder))
    points = points_of(cube)
    places = places_of(points)
    measured_with = json.loads(cube.attrs["measurement_versions"])
    for quantity in dict.fromkeys(shot.quantity for shot in wanted):
        present = measurements.load(quantity).version
        if measured_with[quantity] != [present]:
            raise ValueError(
                f"{folder}: {quantity} has version {measured_with[quantity]} in place of {present}; measure again "
                f"with 'whipple doctor --remeasure --data {folder}/.whipple', or use another directory"
            )
        for match in matched_observations(points, quantity):
            shot = all_shots[match.observation]
            if shot in wanted and shot.value is not None:
                flags = cubes.FLAGS.of(points, quantity)
                mask = int(flags.isel(run=places.index(dict(match.at))))
                words = [word for bit, word in reading.flag_meanings(flags) if mask & bit]
                yield _row(name, shot) | {
                    "simulated": match.simulation,
                    "numerical_uncertainty": match.simulation_uncertainty,
                    "flags": words,
                }


def _row(name: str, shot: observations.Observation) -> dict[str, Any]:
    """A shot as published, without a simulation."""
    return {
        "table": name,
        "quantity": shot.quantity,
        "unit": measurements.load(shot.quantity).unit,
        "parameters": dict(shot.parameters),
        "observed": shot.value,
        "uncertainty": shot.uncertainty,
        "simulated": None,
        "numerical_uncertainty": None,
        "flags": [],
        "source": shot.source,
        "confidence": shot.confidence,
        "note": shot.note,
    } | ({"bounds": shot.bounds} if shot.bounds else {})


# ---- printed -------------------------------------------------------------------------------------


def pages() -> dict[str, str]:
    """shots.md."""
    kept = stored()
    of_tables = {name: [row for row in kept["shots"] if row["table"] == name] for name in TABLES}
    text = in_markdown(
        "shots",
        kept=kept,
        confidence=CONFIDENCE,
        fewest=FEWEST,
        titles=TITLES,
        grids_of=_grids,
        summary=summary(kept["shots"]),
        tables=[(TITLES[name], _by_source(rows), _rows(rows)) for name, rows in of_tables.items()],
        laws=laws_beside(),
    )
    return {"shots.md": text}


def _grids(grids: Mapping[str, Any]) -> str:
    """The cells across the diameter, and the positions of the grid where there are several."""
    cells = grids["resolution"]
    text = f"{cells} cells" if isinstance(cells, int) else f"{', '.join(map(str, cells))} cells"
    return text + (f" at {grids['offsets']} positions" if "offsets" in grids else "")


def laws_beside() -> str:
    """Each law in its range beside each published crater and hole that has a value."""
    rows = []
    for shot in (*published("craters"), *published("holes")):
        if shot.value is not None:
            for each in (ask(law, laws.shot_from(shot.parameters)) for law in laws.answering(shot.quantity)):
                if each.in_range:
                    use = "" if each.law.use == "verdict" else each.law.use
                    difference = percent(each.value / shot.value - 1.0)
                    law = [each.law.title, _millimetres(each.value), difference, use]
                    place = f"{shot.parameters['projectile']} on {shot.parameters['target']}"
                    rows.append([place, _title(shot.quantity), _millimetres(shot.value), *law])
    return table(["shot", "quantity", "observed / mm", "law", "law / mm", "difference / %", "use"], rows)


def summary(shots: Rows) -> str:
    """Bias and scatter of each table and quantity."""
    header = ["shots of", "quantity", "shots", "bias / %", "scatter / %", "contradictory left out"]
    rows = []
    for title, quantity, every in grouped(shots):
        sound = [row for row in every if DOUBTFUL not in row["note"]]
        count, bias, scatter = cells(sound)
        compared, *others = cells(every)
        rest = f"{count} shots: {bias}, {scatter}" if count != compared else NONE
        rows.append([title, quantity, f"{compared} of {len(every)}", *others, rest])
    return table(header, rows)


def grouped(shots: Rows) -> Iterator[tuple[str, str, Rows]]:
    """The shots of each table and quantity, with the titles of both."""
    for name in TABLES:
        mine = [row for row in shots if row["table"] == name]
        for quantity in dict.fromkeys(row["quantity"] for row in mine):
            yield TITLES[name], _title(quantity), [row for row in mine if row["quantity"] == quantity]


def cells(rows: Rows) -> list[str]:
    """Number of compared shots, bias and scatter in percent."""
    count, bias, scatter = bias_and_scatter(rows)
    if bias is None or scatter is None:
        return [str(count), NONE, NONE]
    return [str(count), " to ".join(map(percent, bias)), decimals(100.0 * scatter, 1)]


def percent(value: float) -> str:
    return NONE if math.isnan(value) else signed(100.0 * value, 1)


def _title(quantity: str) -> str:
    return measurements.load(quantity).title


def _by_source(rows: Rows) -> str:
    sources = list(dict.fromkeys((row["source"], row["quantity"]) for row in rows))
    if len(rows) < 4:
        return ""
    lines = []
    for source, quantity in sources:
        mine = [row for row in rows if (row["source"], row["quantity"]) == (source, quantity)]
        lines.append([source, _title(quantity), *cells(mine)])
    return table(["source", "quantity", "shots", "bias / %", "scatter / %"], lines)


def _rows(rows: Rows) -> str:
    """Each shot, below its source; parameters that all of them share stand in the table's file."""
    varied = [
        name
        for name in rows[0]["parameters"]
        if len({row["parameters"].get(name) for row in rows}) > 1 or name == "speed"
    ]
    scenario, _ = TABLES[rows[0]["table"]]
    units = {each.name: each.unit for each in declared(scenarios.load(scenario).parameters).values()}
    header = [
        *(_headed(name, units[name]) for name in varied),
        "quantity", "observed / mm", f"simulated / mm{_meshes(rows)}", "difference / %", "note",
    ]  # fmt: skip
    lines: list[list[str]] = []
    source = ""
    for row in rows:
        if row["source"] != source:
            source = row["source"]
            lines.append([f"**{source}**", *[""] * (len(header) - 1)])
        at = [_shown(row["parameters"].get(name), units[name]) for name in varied]
        uncertainty = row["uncertainty"]
        observed = " to ".join(map(_millimetres, row.get("bounds") or (row["observed"] or 0.0,)))
        if uncertainty is not None:
            observed += f" ± {_millimetres(uncertainty)}"
        simulated = NONE if row["simulated"] is None else _millimetres(row["simulated"])
        if row["numerical_uncertainty"] is not None:
            simulated = with_bar(simulated, _millimetres(row["numerical_uncertainty"]))
        flags = [f"`{flag}`" for flag in row["flags"]]
        note = "; ".join(filter(None, [row["note"], *flags]))
        lines.append([*at, _title(row["quantity"]), observed, simulated, percent(ratio(row)), note])
    return table(header, lines)


def _meshes(rows: Rows) -> str:
    """A note for the column of simulations where none has an error bar."""
    barred = any(row["numerical_uncertainty"] is not None for row in rows)
    return "" if barred else f" (one grid: {MESH_UNKNOWN})"


def _headed(name: str, unit: str | None) -> str:
    shown = display_of(unit).unit
    return name.replace("_", " ") + (f" / {shown}" if shown else "")


def _shown(value: Any, unit: str | None) -> str:
    return value if isinstance(value, str) else f"{value * display_of(unit).factor:g}"


def _millimetres(value: float) -> str:
    return decimals(1e3 * value, 2)


def drawings() -> dict[str, str]:
    """Residuals against speed."""
    panels = []
    for name in TABLES:
        mine = [row for row in stored()["shots"] if row["table"] == name]
        series = {
            _title(quantity): [
                (float(row["parameters"]["speed"]), 100.0 * ratio(row))
                for row in mine
                if row["quantity"] == quantity and not math.isnan(ratio(row))
            ]
            for quantity in dict.fromkeys(row["quantity"] for row in mine)
        }
        panels.append((TITLES[name], series))
    return {"shots.svg": plots.residuals(panels)}
