"""mesh-error.md: what the mesh does to a measured number, known from an ensemble of impacts.

``python -m docs.pages compute mesh-error [DIRECTORY]`` computes the runs of the ensemble that its table does not have,
by their identities, and writes the table as they end; a directory keeps the results of those that are cut. Series,
grids, the model's terms and the split that tests it stand in mesh-error.md and were written before any run.
"""

import csv
import json
import math
import random
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import cache
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from docs.pages import computed_once, table
from solver import PHYSICS_VERSION
from studies import materials
from studies.convergence import experience
from studies.runs.run import Run, estimate, resolve
from studies.scenarios.parts.matter import yield_stress

TABLE = Path(__file__).parents[2] / "studies" / "convergence" / "ensemble.csv"
WORKERS = 2
SEED = 20261128

# A file for each metal that ships; other files describe the same metals by other models, or tool steel without an
# equation of state.
METALS = (
    *("al-1100-o", "al-2017-t4", "al-2024-t3", "al-2024-t351", "al-2219-t87", "al-5456-h116", "al-6061-t6"),
    *("al-7075-t6", "armco-iron", "copper-ofhc", "lead", "steel-304", "steel-4340", "ti-6al-4v", "tungsten"),
    "weldox-460-e",
)
SPEED = (1.5e3, 8e3)  # m/s
DIAMETER = (4e-3, 20e-3)  # m: of matter whose strength depends on the rate
THICKNESS = (0.05, 1.0)  # thickness of a plate over the projectile's diameter
LENGTH = (0.5, 2.0)  # length of a cylinder over its diameter
EACH = 6  # plates of each metal, half of them hit by the same metal
EVERY = 4  # of these projectiles one is a cylinder

CELLS = (10, 14, 20, 28, 40, 56, 80, 112, 160)  # across the projectile
FINEST = 56  # every series of plates has it
THROUGH, LEAST_THROUGH = 8.0, 2.0  # cells through the plate: of its finest grid, and of its coarsest at least

BLOCKS, BLOCK_CELLS, FINE_BLOCKS, FINE_BLOCK_CELLS = 30, (8, 12, 16, 24), 8, 40
# Size of a block in projectile diameters, its edges absorbing: of a projectile up to so many times as dense as the
# block, whose crater is hardly deeper than three diameters at 8 km/s, and of another, which goes deeper.
DENSER, NEAR_EDGES, FAR_EDGES = 1.5, 8.0, 14.0

BARS, BAR_CELLS = 20, (6, 8, 12, 16, 24, 36)
BAR_LENGTH, BAR_DIAMETER = (3.0, 6.0), (5e-3, 12e-3)  # length over diameter; m
BAR_LOAD = (0.3, 2.0)  # rho v^2 over the yield stress at a plastic strain of one

CLOUDS = 24  # plates whose debris is measured too, on the grids of up to ``FINEST`` cells

SPACES = (("quarter", 0.0), ("half", 0.0), ("half", 30.0), ("half", 60.0))  # each three times; degrees
SPACE_THICKNESS, SPACE_CELLS, EACH_SPACE = (0.25, 1.0), (8, 12, 18), 3

FINE, WIDEST_BAR = 24.0, 0.06  # cells across, and the bar that no shot of a domain exceeds on these

QUANTITIES = {
    "thin_plate": ("hole_diameter", "hole_diameter_areal"),
    "debris_cloud": ("tip_velocity_percent",),
    "thick_plate": ("crater_depth", "crater_diameter", "crater_depth_over_diameter"),
    "taylor_bar": ("final_length", "mushroom_diameter", "width_at_fifth"),
    "whipple_shield": ("bumper_hole_diameter",),
}


FURTHER_CELLS, FIRST_FURTHER = (24, 64), 1000
EIGHT_MILLIMETRES = {"projectile_diameter": 8e-3, "speed": 5e3, "plate_thickness": 2e-3}
OTHERS: Mapping[str, Mapping[str, Any]] = {
    "steel on aluminium": {"projectile": "steel-4340", "target": "al-6061-t6"},
    "tungsten on steel": {"projectile": "tungsten", "target": "steel-4340"},
    "oblique hole": {"projectile": "al-6061-t6", "target": "al-6061-t6", "obliquity": math.radians(45.0)},
    "cylinder of three diameters": {
        **{"projectile": "copper-ofhc", "target": "copper-ofhc"},
        **{"projectile_shape": "cylinder", "projectile_length": 24e-3},
    },
    "t/d 0.04": {"projectile": "al-6061-t6", "target": "al-6061-t6", "plate_thickness": 0.32e-3},
}


# The shield of the README.
SHIELD = {
    **{"projectile": "al-2017-t4", "bumper": "al-6061-t6", "wall": "al-6061-t6", "projectile_diameter": 5e-3},
    **{"speed": 6e3, "bumper_thickness": 1.2e-3, "stand_off": 0.1, "wall_thickness": 3.2e-3},
}


@dataclass(frozen=True)
class Series:
    """One shot on several grids."""

    number: int
    kind: str  # plate, cloud, block, bar or space
    scenario: str
    parameters: Mapping[str, Any]  # SI, without cells and offset
    grids: tuple[tuple[int, float], ...]  # cells across, and the shift of the grid in cells

    def runs(self) -> Iterator[tuple[int, float, Run]]:
        """Each grid with its run; raises InvalidInput where a shot cannot be computed."""
        for cells, offset in self.grids:
            numbers: dict[str, Any] = {"cells_per_diameter": float(cells)}
            if self.kind != "bar":
                numbers["offset"] = offset
            yield cells, offset, resolve(self.scenario, {**self.parameters, **numbers})


@cache
def drawn() -> tuple[Series, ...]:
    """The series of the ensemble, by the seed."""
    chance = random.Random(SEED)
    plates = [*_plates(chance)]
    shots = [*plates, *_clouds(chance, plates), *_blocks(chance), *_bars(chance), *_spaces(chance)]
    return tuple(Series(number, *shot) for number, shot in enumerate(shots))


_Shot = tuple[str, str, dict[str, Any], tuple[tuple[int, float], ...]]


def _spread(chance: random.Random, count: int, low: float, high: float, *, log: bool = False) -> Iterator[float]:
    """A value in each of ``count`` equal parts of a range, in an order that is drawn: a Latin hypercube's column."""
    places = [(place + chance.random()) / count for place in range(count)]
    chance.shuffle(places)
    for place in places:
        yield float(f"{low * (high / low) ** place if log else low + (high - low) * place:.4g}")


def _pair(chance: random.Random, target: str, like: bool) -> dict[str, Any]:
    projectile = target if like else chance.choice([metal for metal in METALS if metal != target])
    return {"projectile": projectile, "target": target}


def _body(chance: random.Random, diameter: float, is_cylinder: bool) -> dict[str, Any]:
    length = float(f"{diameter * chance.uniform(*LENGTH):.4g}")
    shape = {"projectile_shape": "cylinder", "projectile_length": length} if is_cylinder else {}
    return {"projectile_diameter": diameter, **shape}


def _offsets(chance: random.Random, cells: Sequence[int]) -> tuple[tuple[int, float], ...]:
    return tuple((count, round(chance.random(), 3) % 1.0) for count in cells)


def _grids_of_plate(ratio: float) -> list[int]:
    """Cells across the projectile, of a plate of so many of its diameters."""
    enough = [cells for cells in CELLS if cells >= FINEST and cells * ratio >= THROUGH]
    finest = enough[0] if enough else CELLS[-1]
    return [cells for cells in CELLS if cells <= finest and cells * ratio >= LEAST_THROUGH]


def _plates(chance: random.Random) -> Iterator[_Shot]:
    count = EACH * len(METALS)
    speeds, ratios = _spread(chance, count, *SPEED), _spread(chance, count, *THICKNESS, log=True)
    diameters = _spread(chance, count, *DIAMETER, log=True)
    targets = [(metal, place % 2 == 0) for metal in METALS for place in range(EACH)]
    cylinders = [place % EVERY == 0 for place in range(count)]
    chance.shuffle(cylinders)
    for (target, like), is_cylinder, speed, ratio, diameter in zip(
        targets, cylinders, speeds, ratios, diameters, strict=True
    ):
        shot = {**_pair(chance, target, like), **_body(chance, diameter, is_cylinder), "speed": speed}
        shot["plate_thickness"] = float(f"{ratio * diameter:.4g}")
        yield "plate", "thin_plate", shot, _offsets(chance, _grids_of_plate(ratio))


def _clouds(chance: random.Random, plates: Sequence[_Shot]) -> Iterator[_Shot]:
    for _, _, shot, grids in chance.sample(plates, CLOUDS):
        cells = [count for count, _ in grids if count <= FINEST]
        if len(cells) > 1:
            yield "cloud", "debris_cloud", shot, _offsets(chance, cells)


def _blocks(chance: random.Random) -> Iterator[_Shot]:
    speeds, diameters = _spread(chance, BLOCKS, *SPEED), _spread(chance, BLOCKS, *DIAMETER, log=True)
    targets = [(metal, True) for metal in METALS]
    targets += [(chance.choice(METALS), False) for _ in range(BLOCKS - len(targets))]
    fine = set(chance.sample(range(BLOCKS), FINE_BLOCKS))
    for place, ((target, like), speed, diameter) in enumerate(zip(targets, speeds, diameters, strict=True)):
        pair = _pair(chance, target, like)
        dense = materials.load(pair["projectile"]).density > DENSER * materials.load(target).density
        size = float(f"{(FAR_EDGES if dense else NEAR_EDGES) * diameter:.4g}")
        shot = {**pair, **_body(chance, diameter, place % EVERY == 0), "speed": speed, "edges": "absorbing"}
        cells = (*BLOCK_CELLS, FINE_BLOCK_CELLS) if place in fine and not dense else BLOCK_CELLS
        yield "block", "thick_plate", {**shot, "target_depth": size, "target_radius": size}, _offsets(chance, cells)


def _bars(chance: random.Random) -> Iterator[_Shot]:
    loads, diameters = _spread(chance, BARS, *BAR_LOAD, log=True), _spread(chance, BARS, *BAR_DIAMETER, log=True)
    metals = [*METALS, *chance.sample(METALS, BARS - len(METALS))]
    for metal, load, diameter in zip(metals, loads, diameters, strict=True):
        material = materials.load(metal)
        strength = yield_stress(material, 1.0)
        assert strength is not None
        shot = {
            "bar": metal,
            "speed": float(f"{math.sqrt(load * strength / material.density):.4g}"),
            "bar_diameter": diameter,
            "bar_length": float(f"{diameter * chance.uniform(*BAR_LENGTH):.4g}"),
        }
        yield "bar", "taylor_bar", shot, _offsets(chance, BAR_CELLS)


def _spaces(chance: random.Random) -> Iterator[_Shot]:
    places = [place for place in SPACES for _ in range(EACH_SPACE)]
    speeds, ratios = _spread(chance, len(places), *SPEED), _spread(chance, len(places), *SPACE_THICKNESS, log=True)
    for (geometry, degrees), speed, ratio in zip(places, speeds, ratios, strict=True):
        diameter = float(f"{chance.uniform(*DIAMETER):.4g}")
        shot = {**_pair(chance, chance.choice(METALS), chance.random() < 0.5), "projectile_diameter": diameter}
        shot |= {"speed": speed, "geometry": geometry, "plate_thickness": float(f"{ratio * diameter:.4g}")}
        if degrees:
            shot["obliquity"] = math.radians(degrees)
        yield "space", "thin_plate", shot, _offsets(chance, SPACE_CELLS)


@cache
def further() -> tuple[Series, ...]:
    """Series that no model is fitted to: six plates and two blocks that are drawn, and shots of other kinds."""
    chance = random.Random(SEED + 1)
    shots: list[_Shot] = []
    for speed, ratio in zip(_spread(chance, 6, *SPEED), _spread(chance, 6, *THICKNESS, log=True), strict=True):
        diameter = float(f"{chance.uniform(*DIAMETER):.4g}")
        shot = {**_pair(chance, chance.choice(METALS), chance.random() < 0.5), **_body(chance, diameter, False)}
        shot |= {"speed": speed, "plate_thickness": float(f"{ratio * diameter:.4g}")}
        shots.append(("plate", "thin_plate", shot, _offsets(chance, FURTHER_CELLS)))
    for speed in _spread(chance, 2, *SPEED):
        diameter = float(f"{chance.uniform(*DIAMETER):.4g}")
        shot = {**_pair(chance, chance.choice(METALS), True), **_body(chance, diameter, False), "speed": speed}
        size = {name: float(f"{NEAR_EDGES * diameter:.4g}") for name in ("target_depth", "target_radius")}
        cells = (BLOCK_CELLS[1], FINE_BLOCK_CELLS)
        shots.append(("block", "thick_plate", {**shot, **size, "edges": "absorbing"}, _offsets(chance, cells)))
    for name, other in OTHERS.items():
        oblique = {"geometry": "half"} if "obliquity" in other else {}
        cells = (SPACE_CELLS[1], 2 * SPACE_CELLS[1]) if oblique else FURTHER_CELLS
        shots.append((name, "thin_plate", {**EIGHT_MILLIMETRES, **other, **oblique}, _offsets(chance, cells)))
    shots.append(("bumper", "whipple_shield", dict(SHIELD), _offsets(chance, (FURTHER_CELLS[0], 2 * FURTHER_CELLS[0]))))
    return tuple(Series(FIRST_FURTHER + number, *shot) for number, shot in enumerate(shots))


# ---- computed ------------------------------------------------------------------------------------


def expected_cost() -> dict[str, float]:
    """Core hours of each kind, by the estimate of its runs."""
    hours: dict[str, float] = {}
    for series in drawn():
        seconds = sum(estimate(run).core_seconds for _, _, run in series.runs())
        hours[series.kind] = hours.get(series.kind, 0.0) + seconds / 3600.0
    return hours


def compute(directory: Path | None = None) -> None:
    """Compute the runs that neither the table nor a directory has, the cheap ones first, and store each as it ends."""
    rows = {row["id"]: row for row in stored() if row["physics"] == str(PHYSICS_VERSION)}
    every = (*drawn(), *further()) if experience.stored() else drawn()
    places = [(series.number, cells, offset, run) for series in every for cells, offset, run in series.runs()]
    places.sort(key=lambda place: estimate(place[3]).core_seconds)
    with (
        tempfile.TemporaryDirectory() as temporary,
        ProcessPoolExecutor(WORKERS, mp_context=get_context("spawn")) as pool,
    ):
        folder = (directory or Path(temporary)).resolve()
        absent = [place for place in places if place[3].id not in rows]
        for row in pool.map(computed_row, absent, [folder] * len(absent)):
            rows[row["id"]] = row
            store([rows[place[3].id] for place in places if place[3].id in rows])


def computed_row(place: tuple[int, int, float, Run], folder: Path) -> dict[str, Any]:
    """What the run of a series on one grid says."""
    number, cells, offset, run = place
    result = computed_once(run, folder / run.id)
    print(number, cells, result.state, flush=True)
    measured = {name: result.measurements.get(name) for name in QUANTITIES[run.scenario]}
    values = {name: each.value if each else None for name, each in measured.items()}
    flags = sorted({flag for each in measured.values() if each for flag in each.flags} | {*result.flags})
    return {
        **{"physics": PHYSICS_VERSION, "series": number, "cells": cells, "offset": offset, "id": run.id},
        **{"state": result.state, "flags": " ".join(flags)},
        **{"seconds": round(float(result.provenance.get("seconds", math.nan)), 1), **values},
    }


def stored() -> list[dict[str, str]]:
    """The rows of the table as texts; none where there is no table."""
    if not TABLE.exists():
        return []
    with TABLE.open(encoding="utf-8", newline="") as file:
        return [*csv.DictReader(file)]


HEADER = ("physics", "series", "cells", "offset", "id", "state", "flags", "seconds")


def store(rows: Sequence[Mapping[str, Any]]) -> None:
    """Write the table, by series and cells."""
    names = [*HEADER, *dict.fromkeys(name for names in QUANTITIES.values() for name in names)]
    ordered = sorted(rows, key=lambda row: (int(row["series"]), int(row["cells"])))
    with TABLE.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, names, lineterminator="\n")
        writer.writeheader()
        writer.writerows(ordered)


def pages() -> dict[str, str]:
    """mesh-error.md."""
    counts = {kind: sum(series.kind == kind for series in drawn()) for kind in KINDS}
    runs = {kind: sum(len(series.grids) for series in drawn() if series.kind == kind) for kind in KINDS}
    rows = [[kind, str(counts[kind]), str(runs[kind]), KINDS[kind]] for kind in KINDS]
    parts = [
        "# The mesh error, known from experience\n",
        RULE,
        table(["kind", "series", "runs", "drawn"], rows),
        *_results(),
    ]
    return {"mesh-error.md": "\n".join(parts)}


def _results() -> Iterator[str]:
    """What is stored of each quantity: its domain, its coefficients, and how it was tested."""
    plain = json.loads(experience.STORED.read_text(encoding="utf-8"))
    known = plain["quantities"] if plain["physics"] == PHYSICS_VERSION else {}
    if not known:
        yield "\n## Results\n\nThe ensemble is not complete, so that every mesh error is unknown.\n"
        return
    tests, models, domains = [], [], []
    for name, each in known.items():
        kept, tested = experience.Experience.from_json(each), each["tested"]
        model = kept.model
        shares = [f"{100 * share:.0f} % of {of}" for share, of in tested["covered"].values()]
        counted = "{} of {}".format(*tested["series"])
        tests.append(
            [
                *(f"`{name}`", counted, *([*shares, ""])[:3], f"{tested['wider']:.2f}"),
                *(f"{tested['bar_over_error']:.1f}", f"{100 * tested['widest_bar']:.1f} %"),
            ]
        )
        in_space = "unknown" if model.in_space is None else f"{model.in_space:.2f}"
        coefficients = [
            ", ".join(f"{term} {value:.3g}" for term, value in part.items()) for part in (model.bias, model.scale)
        ]
        models.append([f"`{name}`", *coefficients, in_space, "yes" if model.independent else "no"])
        domains.append([f"`{name}`", *(f"{low:.3g} to {high:.3g}" for low, high in vars(kept.domain).values())])
    yield "\n## Results\n"
    held = ("held, metals left out", "speeds", "t/d", "scale times")
    yield table(["quantity", "series inside", *held, "bar over error", f"widest bar on {FINE:g} cells"], tests)
    yield "\n"
    yield table(["quantity", "coefficients of B", "scale", "times the scale in 3-D", "grids independent"], models)
    yield "\nThe domains, in SI; more cells than any of the ensemble are inside:\n"
    yield table(["quantity", *(name.replace("_", " ") for name in next(iter(known.values()))["domain"])], domains)


KINDS = {
    "plate": f"each of {len(METALS)} metals hit {EACH} times, half of them by itself; one projectile of {EVERY} a "
    f"cylinder, {LENGTH[0]:g} to {LENGTH[1]:g} diameters long; {SPEED[0] / 1e3:g} to {SPEED[1] / 1e3:g} km/s, "
    f"{1e3 * DIAMETER[0]:g} to {1e3 * DIAMETER[1]:g} mm, {THICKNESS[0]:g} to {THICKNESS[1]:g} diameters thick; "
    f"{', '.join(map(str, CELLS))} cells across, from {LEAST_THROUGH:g} through the plate on, up to the first from "
    f"{FINEST} on that has {THROUGH:g}",
    "cloud": f"of these plates, with the debris, on the grids up to {FINEST} cells",
    "block": f"each metal by itself, the others by another one; {', '.join(map(str, BLOCK_CELLS))} cells across, "
    f"{FINE_BLOCKS} drawn ones on {FINE_BLOCK_CELLS} too where the projectile is no more than {DENSER:g} times as "
    f"dense; edges absorb, {NEAR_EDGES:g} diameters away, {FAR_EDGES:g} of a denser projectile",
    "bar": f"bars of all metals, {BAR_LENGTH[0]:g} to {BAR_LENGTH[1]:g} diameters long, at speeds at which rho v^2 is "
    f"{BAR_LOAD[0]:g} to {BAR_LOAD[1]:g} yield stresses; {', '.join(map(str, BAR_CELLS))} cells across",
    "space": "a quarter and a half at normal incidence, a half at 30 and 60 degrees; "
    f"{', '.join(map(str, SPACE_CELLS))} cells across",
}

RULE = f"""Series of shots, each on several grids, tell how far a coarse grid is off. This page was written before any
of their runs; the seed is {SEED}. All parameters that are not named are the defaults, so that the answer is that of the
default recipe, and the position of the grid is drawn anew for each run. The expected cost is 10.5 core hours.
Recomputed by `python -m docs.pages compute mesh-error DIRECTORY`, which resumes; rows of another physics version do not
count.

## The model

Of a quantity Q (hole, tip velocity, crater depth, crater diameter, their ratio, sizes of bars) on a grid with n_d cells
across the projectile and n_t through the plate:

    ln Q(grid) - ln Q(limit) = B + noise,    B = a / n_t^2 + b / n_d
    a, b = c_0 + c_v ln(v / 4 km/s) + c_s ln(Y_t / 300 MPa) + c_r ln(rho_p / rho_t)

The first term is the plate that is too stiff and too coarse to carry a wave: second order, as the scheme is. The second
is the surface of what is hit, which is blurred by part of a cell: first order. Blocks and bars have n_d alone, bars
their own diameter in its place and no ratio of densities; e / n_d^2 stands in place of the first term. c_v, c_s, c_r
and e are in the model of a quantity where each lowers the median size of what is left of metals that are left out, of
the training series alone, by a tenth; else the smaller model stands.

The noise has Student's distribution with five degrees of freedom (Lange, Little and Taylor 1989, J. Am. Stat. Assoc.
84, 881), of the scale s with s^2 = s_0^2 + (s_t / n_t^2)^2 + (s_d / n_d)^2. All constants come from maximum likelihood
of the differences of each grid and the finest one of its series, ln Q(grid) - ln Q(finest), whose centre is
B(grid) - B(finest) and whose scale is that of both.

The yield stress is that of the target's first slip, cold and slow.

## Several grids

Corrected values of one shot are averaged with the inverse squares of their scales. What is left on two grids counts
as independent, so that both narrow the bar, where the interval of 95 % of the two coarsest grids together holds 90 % of
the values of the finest one, of metals that are left out; else the bar is that of the most certain grid. Offsets on one
grid are averaged and narrow nothing. Where the finest grid and another differ by more than the 99 % of their scales
together the grids disagree, and the bar holds what is seen.

## What counts

A run counts where it succeeded and its quantity has a value; a series, where its finest grid counts and one coarser
one. A value that has not settled at the end of the run counts too: all grids of a series are read at the same time.

## The test

Series are left out by target metal, by t/d (below 0.15, to 0.4, above; plates alone) and by speed (below 3 km/s, to
5.5, above), the model is fitted to the others, and each difference of a left-out series is compared with its interval
of 95 %: of each of these three ways and each quantity 90 to 99 % must lie inside. Where that does not hold the domain
of the quantity is drawn narrower, first by fewest cells (through the plate 3, then 4; across 14), then by speed (from
2 km/s, then 2.5), then by t/d (from 0.1), and the page says so; at most 20 % of the series may fall out. The same
where on {FINE:g} cells that are inside the bar of a series is above {100 * WIDEST_BAR:g} %. Where no such domain
holds, the scale is widened by one factor, the least with which each of the three ways holds 90 %, and the widest
domain that then holds counts. Outside of the domain the mesh error is unknown. The domain has the ranges of the
ensemble in speed, t/d, length of cylinders, ratio of densities and strength of the target; in three dimensions
the same model counts if its interval holds 90 % of the differences there, else the scale is widened by one factor
for three dimensions until it does.

Three sentences of this rule were written after trial fits to a part of the table and before the fit that counts: values
that have not settled were left out before, and with them a third of the plates; a plate of 2.4 cells had a bar of 12 %
on 24 cells across; and the scale was widened in three dimensions alone, so that sizes of bars had no bar.

Six more plates on 64 cells and two more blocks on {FINE_BLOCK_CELLS} are drawn after the model is fitted and before
they are run, and compared with the answers of 24 and 12 cells.
"""
