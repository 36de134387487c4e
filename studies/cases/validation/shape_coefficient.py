"""Depth over diameter of craters by speed, for three kinds of pairs of materials: Ma (2005), section 1.2.1, Fig. 1.1.

The curves of the figure are not recoverable. What the text says of them stands beside our craters: a denser and
stronger projectile makes a deep hole, which becomes less deep over its diameter with the speed as soon as the
projectile breaks; a lighter and weaker one makes a shallow dish; like on like lies between; all tend to a half. It is
shown and not gated: a depth ends where matter connected to the target begins, that of the projectile too, so that a
projectile which stays whole at 1 and 2 km/s fills its hole.
"""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np
import xarray as xr

from studies.cases.compared import ComparedReading, Line, Picture
from studies.cases.validation import Cubes, Document, ValidationCase, ValidationLevel, numbers_of
from studies.quantities.comparison import Comparison
from studies.quantities.parameters import Plain

QUANTITY = "crater_depth_over_diameter"
DEEP, LIKE, SHALLOW = "steel-on-aluminium", "copper-on-copper", "aluminium-on-steel"
PAIRS = {
    DEEP: ("steel-4340", "al-6061-t6"),
    LIKE: ("copper-ofhc", "copper-ofhc"),
    SHALLOW: ("al-6061-t6", "steel-4340"),
}
LIMIT = 0.5  # Ma (2005), section 1.2.1
SPEEDS, QUICK = (1, 2, 4, 6, 8), (6,)  # km/s
CELLS: Mapping[ValidationLevel, Plain] = {"quick": 5, "thesis": 9, "fine": [6, 9, 13.5]}
SMALL_BLOCK = {"target_depth": "30 mm", "target_radius": "25 mm"}


def _sweeps(level: ValidationLevel) -> Mapping[str, Document]:
    speeds = QUICK if level == "quick" else SPEEDS
    points = [(*pair, f"{speed} km/s") for pair in PAIRS.values() for speed in speeds]
    projectiles, targets, every_speed = (list(column) for column in zip(*points, strict=True))
    return {
        "craters": {
            "title": "Shape of craters: Ma (2005), Fig. 1.1",
            "scenario": "thick_plate",
            "fixed": {
                "projectile_diameter": "5 mm",
                "particles_per_cell": 2,
                **(SMALL_BLOCK if level == "quick" else {}),
            },
            "axes": {"projectile": projectiles, "target": targets, "speed": every_speed},
            "combine": "zip",
            "resolution": CELLS[level],
        }
    }


def _readings(cube: xr.Dataset, name: str) -> list[ComparedReading]:
    """The craters of a pair, by speed."""
    projectile, target = PAIRS[name]
    pair = {"projectile": projectile, "target": target}
    return [ComparedReading(cube, QUANTITY, {**pair, "speed": float(speed)}) for speed in np.unique(cube.speed.values)]


def _rows(level: ValidationLevel, cubes: Cubes) -> Iterator[Comparison]:
    readings = {name: _readings(cubes["craters"], name) for name in PAIRS}
    shapes = {name: [each.best[0] for each in mine] for name, mine in readings.items()}
    deep, like, shallow = (shapes[name] for name in PAIRS)
    between = [low < it < high for low, it, high in zip(shallow, like, deep, strict=True)]
    expected = [
        (DEEP, f"above {LIMIT}", [shape > LIMIT for shape in deep]),
        (LIKE, "between the others", between),
        (SHALLOW, f"below {LIMIT}", [shape < LIMIT for shape in shallow]),
    ]
    if level != "quick":
        expected += [
            (name, f"nearest to {LIMIT} at the highest speed", [_approaches(shapes[name])]) for name in (DEEP, SHALLOW)
        ]
    for name, words, holds in expected:
        others = _beside() if name == LIKE else {}
        got = f"{_texts(readings[name])}: {sum(holds)} of {len(holds)} so"
        yield Comparison(_claim(readings[name]), words, got, None, others=others)


def _claim(readings: Sequence[ComparedReading]) -> str:
    at = readings[0].at
    speeds = ", ".join(f"{float(each.at['speed']) / 1e3:g}" for each in readings)
    return f"{at['projectile']} on {at['target']}: depth over diameter at {speeds} km/s"


def _texts(readings: Sequence[ComparedReading]) -> str:
    return ", ".join(each.text for each in readings)


def _approaches(shapes: Sequence[float]) -> bool:
    """Whether the last ratio is nearer to the limit than each before it, of two at least."""
    *before, last = (abs(shape - LIMIT) for shape in shapes)
    return bool(before) and last < min(before)


def _beside() -> dict[str, float]:
    """The published ratios of copper on copper."""
    return {
        f"{each.by} at {each.at('speed') / 1e3:g} km/s": each.value
        for each in numbers_of("shape_coefficient", "thick_plate")
    }


def _pictures(cubes: Cubes) -> Iterator[Picture]:
    lines = [
        Line(
            name.replace("-", " "),
            tuple((float(each.at["speed"]) / 1e3, *each.point) for each in _readings(cubes["craters"], name)),
        )
        for name in PAIRS
    ]
    numbers = numbers_of("shape_coefficient", "thick_plate")
    for by in dict.fromkeys(each.by for each in numbers):
        points = [(each.at("speed") / 1e3, each.value, 0.0) for each in numbers if each.by == by]
        lines.append(Line(f"{by}, copper", tuple(points)))
    title = "Shape of craters (Fig. 1.1)"
    yield Picture("shape-coefficient", title, "speed (km/s)", "crater depth over diameter", tuple(lines))


CASE = ValidationCase(
    name="shape-coefficient",
    says="shown: craters of a denser and stronger projectile should be deeper than half of their diameter, those of a "
    "lighter and weaker one shallower, both nearer to a half with the speed, and like on like between",
    source="Ma (2005), section 1.2.1, whose figure 1.1 is not recoverable; Tables 3.3 and 3.4",
    sweeps=_sweeps,
    rows=_rows,
    pictures=_pictures,
)
