"""mesh-error.md: what the mesh does to a measured number, known from an ensemble of impacts.

``python -m docs.pages compute mesh-error [DIRECTORY]`` computes the runs of the ensemble that its table does not have,
by their identities, and writes the table as they end; a directory keeps the results of those that are cut. Series,
grids, the model's terms and the split that tests it stand in mesh-error.md and were written before any run.
"""

import csv
import json
import math
import random
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cache
from pathlib import Path
from typing import Any

from docs.pages import KeptRow, computed_once, computed_rows, in_markdown, table
from solver import PHYSICS_VERSION
from studies import materials
from studies.convergence import experience
from studies.runs.run import Run, estimate, resolve
from studies.scenarios.parts.matter import yield_stress

TABLE = Path(__file__).parents[2] / "studies" / "convergence" / "ensemble.csv"
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

# Plates of metals that are softer than this, hit fast, which the series above hold too few of.
SOFT, SOFT_PLATES, SOFT_SPEED, SOFT_THICKNESS = 1e8, 12, (5.5e3, 8e3), (0.15, 0.6)  # Pa, m/s, in diameters

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
    shots += _soft_plates(random.Random(SEED + 2))
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


def _soft_plates(chance: random.Random) -> Iterator[_Shot]:
    strengths = {metal: yield_stress(materials.load(metal)) for metal in METALS}
    soft = [metal for metal, strength in strengths.items() if strength is not None and strength < SOFT]
    speeds, ratios = _spread(chance, SOFT_PLATES, *SOFT_SPEED), _spread(chance, SOFT_PLATES, *SOFT_THICKNESS, log=True)
    diameters = _spread(chance, SOFT_PLATES, *DIAMETER, log=True)
    for place, (speed, ratio, diameter) in enumerate(zip(speeds, ratios, diameters, strict=True)):
        target = soft[place % len(soft)]
        shot = {**_pair(chance, target, True), **_body(chance, diameter, False), "speed": speed}
        shot["plate_thickness"] = float(f"{ratio * diameter:.4g}")
        yield "plate", "thin_plate", shot, _offsets(chance, _grids_of_plate(ratio))


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


def compute(directory: Path | None = None) -> None:
    """Compute the runs that neither the table nor a directory has, the cheap ones first, and store each as it ends."""
    rows: dict[str, KeptRow] = {row["id"]: row for row in stored() if row["physics"] == str(PHYSICS_VERSION)}
    every = (*drawn(), *further()) if experience.stored() else drawn()
    places = [(series.number, cells, offset, run) for series in every for cells, offset, run in series.runs()]
    places.sort(key=lambda place: estimate(place[3]).core_seconds)
    for row in computed_rows(computed_row, [place for place in places if place[3].id not in rows], directory):
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
    """mesh-error.md: the rule, as it was written before the runs, and what is stored of each quantity by it."""
    plain = json.loads(experience.STORED.read_text(encoding="utf-8"))
    known = experience.stored()
    tests, models, domains = [], [], []
    for name, kept in known.items():
        model, tested = kept.model, plain["quantities"][name]["tested"]
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
    held = ("held, metals left out", "speeds", "t/d", "scale times")
    text = in_markdown(
        "mesh_error",
        tests=table(["quantity", "series inside", *held, "bar over error", f"widest bar on {FINE:g} cells"], tests),
        models=table(["quantity", "coefficients of B", "scale", "times the scale in 3-D", "grids independent"], models),
        domains=table(["quantity", *(each.name.replace("_", " ") for each in fields(experience.Domain))], domains),
        is_complete=bool(known),
    )
    return {"mesh-error.md": text}
