"""A verdict on every law of holes, from holes in aluminium and copper at 2 to 7 km/s in plates of 0.1 to 0.6 diameters.

The cost grows with (t/d)^-3: with 4, 8 and 16 cells through the plate's thickness t/d = 0.1 takes a core about 35
minutes, at 0.1 us a particle-step, and the other thicknesses together about 15.
"""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise, product
from operator import itemgetter

import numpy as np
import xarray as xr

from studies import laws
from studies.cases.compared import ComparedReading, Line, Picture
from studies.cases.validation import Cubes, Document, ValidationCase, ValidationLevel
from studies.cubes.points import Place, points_of
from studies.quantities.comparison import Comparison, reported
from studies.quantities.display import decimals, signed
from studies.quantities.least_squares import linear
from studies.reports.judgement import judgements_of
from studies.reports.records import Judgement, Outcome, PointJudgement

QUANTITY = "hole_diameter"
DIAMETER = 8e-3  # m
MATERIALS = {"aluminium": "al-2024-t3", "copper": "copper-ofhc"}
SPEEDS = (2.0, 3.0, 4.0, 5.0, 6.0, 7.0)  # km/s
DESIGN = dict.fromkeys((0.1, 0.2, 0.4, 0.6), SPEEDS)  # speeds by t/d
THROUGH = (4, 8, 16)  # cells through the plate
# Speeds without the finest grid, by cost alone: thin aluminium goes on moving, at 7 km/s for more than 20 000 steps.
TWO_GRIDS = {("aluminium", 0.1): (7.0,)}
QUICK = {0.2: (2.0, 4.5, 7.0)}
RATIO = "thickness_ratio"
PER = {"speed": ("km/s", 1e3), RATIO: ("0.1 of t/d", 0.1)}  # of the trends along each axis, SI
WORDS = {
    Outcome.WITHIN: "inside the joint uncertainty",
    Outcome.LOW: "low",
    Outcome.HIGH: "high",
    Outcome.NOT_COMPARABLE: "without an error bar",
}
MOST_REASONS = 3
SPREAD = 1.0  # joint error bars by which a hole may fall behind that of a slower shot


@dataclass(frozen=True)
class HoleSeries:
    """The holes of a material at a thickness."""

    material: str
    ratio: float  # t/d
    cubes: tuple[xr.Dataset, ...]  # of its sweeps

    @property
    def readings(self) -> list[ComparedReading]:
        """By speed, from the slowest."""
        places = ((cube, float(speed)) for cube in self.cubes for speed in cube.speed.values)
        return [ComparedReading(cube, QUANTITY, {"speed": speed}) for cube, speed in sorted(places, key=itemgetter(1))]


def _sweeps(level: ValidationLevel) -> Mapping[str, Document]:
    if level == "quick":
        return {f"copper-{r:g}": _sweep("copper", r, v, THROUGH[:1]) for r, v in QUICK.items()}
    sweeps = {}
    for material, ratio in product(MATERIALS, DESIGN):
        coarse = TWO_GRIDS.get((material, ratio), ()) if level == "fine" else ()
        speeds = [speed for speed in DESIGN[ratio] if speed not in coarse]
        through = THROUGH if level == "fine" else THROUGH[1:2]
        sweeps[f"{material}-{ratio:g}"] = _sweep(material, ratio, speeds, through)
        if coarse:
            sweeps[f"{material}-coarse-{ratio:g}"] = _sweep(material, ratio, coarse, THROUGH[:2])
    return sweeps


def _sweep(material: str, ratio: float, speeds: Sequence[float], through: Sequence[int]) -> Document:
    cells = [each / ratio for each in through]
    return {
        "title": f"Holes in {material}, t/d = {ratio:g}",
        "scenario": "thin_plate",
        "fixed": {
            "projectile": MATERIALS[material],
            "target": MATERIALS[material],
            "projectile_diameter": f"{1e3 * DIAMETER:g} mm",
            "plate_thickness": f"{1e3 * DIAMETER * ratio:.12g} mm",
        },
        "axes": {"speed": [f"{speed:g} km/s" for speed in speeds]},
        "resolution": cells if len(cells) > 1 else cells[0],
    }


def _series(cubes: Cubes, material: str) -> list[HoleSeries]:
    by_ratio: dict[float, list[xr.Dataset]] = {}
    for name, cube in cubes.items():
        whose, *_, ratio = name.split("-")
        if whose == material:
            by_ratio.setdefault(float(ratio), []).append(cube)
    return [HoleSeries(material, ratio, tuple(own)) for ratio, own in by_ratio.items()]


def _rows(level: ValidationLevel, cubes: Cubes) -> Iterator[Comparison]:
    for material in MATERIALS:
        series = _series(cubes, material)
        if not series:
            continue
        for each in series:
            yield from _of_holes(each)
        subjects = _pooled(series)
        known, told = len(laws.answering(QUANTITY)), len({subject.law.partition("/")[0] for subject in subjects})
        claim = f"{material}: laws of holes with a verdict, or with the reason why there is none"
        yield Comparison(claim, known, told, passed=told == known)
        yield from (_of_law(material, subject) for subject in subjects)


def _of_holes(series: HoleSeries) -> Iterator[Comparison]:
    """Holes over the speed, and what the last refinement changed."""
    where = f"{series.material}, t/d = {series.ratio:g}"
    holes = [reading.point for reading in series.readings]
    grow = all(
        fast - slow >= -SPREAD * float(np.hypot(slow_bar, fast_bar))
        for (slow, slow_bar), (fast, fast_bar) in pairwise(holes)
    )
    listed = ", ".join(reading.text for reading in series.readings)
    speeds = ", ".join(f"{reading.at['speed'] / 1e3:g}" for reading in series.readings)  # type: ignore[operator]
    claim = f"{where}: hole diameter (mm) at {speeds} km/s"
    yield Comparison(claim, "grows", listed, grow)
    by_grids: dict[tuple[str, ...], list[ComparedReading]] = {}
    for reading in series.readings:
        if reading.is_refined:
            through = tuple(f"{cells * series.ratio:.3g}" for cells in reading.grids)
            by_grids.setdefault(through, []).append(reading)
    for (*_, before, after), refined in by_grids.items():
        changes = []
        for reading in refined:
            *_, coarse, fine = (reading.on(cells) for cells in reading.grids)
            changes.append(abs(fine / coarse - 1.0))
        verdicts = Counter(reading.converged[2] for reading in refined)
        told = ", ".join(f"{count} {word}" for word, count in verdicts.most_common())
        claim = f"{where} ({told}): largest change of a hole from {before} to {after} cells through the plate"
        yield reported(claim, max(changes))


def _pooled(series: Sequence[HoleSeries]) -> list[Judgement]:
    """Each law against all holes of a material, with t/d beside the speed as an axis."""
    pooled: dict[str, Judgement] = {}
    for cube, ratio in ((cube, each.ratio) for each in series for cube in each.cubes):
        judgements, _ = judgements_of(points_of(cube), QUANTITY)
        for each in sorted(judgements, key=lambda each: each.law):
            points = tuple(replace(point, at={"speed": point.at["speed"], RATIO: ratio}) for point in each.points)
            before = pooled.get(each.law, replace(each, points=()))
            pooled[each.law] = replace(before, points=before.points + points)
    return list(pooled.values())


def _of_law(material: str, subject: Judgement) -> Comparison:
    """A law beside all holes: mean residual, trends with their intervals, outcomes by points, limits of its range."""
    judged = [point for point in subject.points if point.state == "judged"]
    residuals = np.array([point.difference for point in judged], float)
    beside: dict[str, str] = {"n": f"{len(judged)} of {len(subject.points)}"}
    if subject.drawn_only:
        beside["drawn only"] = subject.drawn_only
    if judged:
        beside["from"] = f"{_percent(residuals.min())} to {_percent(residuals.max())}"
        beside |= _trends([point.at for point in judged], residuals)
        outcomes = Counter(point.outcome for point in judged)
        beside |= {says: str(outcomes[outcome]) for outcome, says in WORDS.items() if outcomes[outcome]}
    for state in ("outside", "unjudged"):
        reasons = Counter(getattr(each, state) for each in subject.points if each.state == state)
        if reasons:
            beside[f"{state}: {reasons.total()}"] = "; ".join(reason for reason, _ in reasons.most_common(MOST_REASONS))
    claim = f"{material}: {subject.title}, mean of law minus hole (%)"
    got = 100.0 * float(residuals.mean()) if judged else "no judged point"
    return Comparison(claim, "", got, None, others=beside)


def _trends(places: Sequence[Place], residuals: np.ndarray) -> dict[str, str]:
    """Slopes of a plane through the residuals (n,) with their intervals, along the axes that the points tell apart."""
    columns = {"": np.ones(len(places))}
    for axis, (words, size) in PER.items():
        values = np.array([float(place[axis]) for place in places]) / size
        wider = np.column_stack([*columns.values(), values - values.mean()])
        if len(places) > wider.shape[1] == np.linalg.matrix_rank(wider):
            columns[f"per {words}"] = values - values.mean()
    if len(columns) == 1:
        return {}
    plane = linear(list(columns.values()), residuals)
    slopes = zip(columns, plane.constants, plane.intervals, strict=True)
    return {
        words: f"{signed(100.0 * slope, 1)} ± {decimals(100.0 * interval, 1)} %"
        for words, slope, interval in slopes
        if words
    }


def _percent(share: float) -> str:
    return f"{signed(100.0 * share, 1)} %"


def _pictures(cubes: Cubes) -> Iterator[Picture]:
    for material in MATERIALS:
        series = _series(cubes, material)
        holes = [
            Line(f"t/d = {each.ratio:g}", tuple((float(at.at["speed"]) / 1e3, *at.point) for at in each.readings))
            for each in series
        ]
        residuals = [
            Line(subject.title, _mean_residuals(subject.points), joined=True)
            for subject in _pooled(series)
            if not subject.drawn_only
        ]
        for name, title, y, lines in (
            ("holes", f"Holes in {material}", "hole diameter (mm)", holes),
            ("residuals", f"Laws minus holes in {material}", "mean over t/d (%)", residuals),
        ):
            drawn = tuple(line for line in lines if line.points)
            if drawn:
                yield Picture(f"{name}-{material}", title, "speed (km/s)", y, drawn)


def _mean_residuals(points: Sequence[PointJudgement]) -> tuple[tuple[float, float, float], ...]:
    by_speed: dict[float, list[float]] = {}
    for point in points:
        if point.state == "judged":
            by_speed.setdefault(float(point.at["speed"]), []).append(point.difference or 0.0)
    return tuple((speed / 1e3, 100.0 * float(np.mean(values)), 0.0) for speed, values in sorted(by_speed.items()))


CASE = ValidationCase(
    name="hole-laws",
    says="holes in aluminium and copper grow with the speed from 2 to 7 km/s in plates of 0.1 to 0.6 diameters "
    "(aluminium at 0.1 and 7 km/s on two grids); of each law of holes the mean residual, its trend with speed and "
    "thickness, and where the law leaves its range",
    source="the laws of holes, which whipple list laws lists",
    sweeps=_sweeps,
    rows=_rows,
    pictures=_pictures,
)
