"""Shots on Whipple shields: those that ship, screened by stated rules, and the user's own; filters, and the nearest."""

import csv
import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import cache, lru_cache, partial
from importlib.resources import files
from itertools import chain, permutations
from typing import Annotated, Literal, get_args

from solver.units import Described, KilogramPerCubicMetre, Metre, MetrePerSecond, Pascal, Radian
from studies.materials import Material, load
from studies.observations.table import (
    TEXT_COLUMNS,
    TO,
    FindingsOfRows,
    exact,
    heading_of,
    is_nothing,
    rows_of,
    yes_or_no,
)
from studies.quantities.findings import Finding, Findings, refusal
from studies.quantities.parameters import Plain, Value, declared, find, missing, nested, parse_value
from studies.shields.shield import ALUMINIUM, Shield, ShotAtShield

WallOutcome = Literal["perforated", "held"]  # of the wall
OUTCOMES: tuple[WallOutcome, ...] = get_args(WallOutcome)
PATH = "shots"
FASTEST = 20e3  # m/s: no gun launches spheres faster
OUTCOME, PERFORATED = "outcome", "perforated"  # columns of a table that say whether the wall was perforated
NAMES = ("source", "shot")  # columns whose numbers are names
WORDS = (*TEXT_COLUMNS, *NAMES, OUTCOME, PERFORATED, "projectile", "bumper", "wall")
STEEPEST = math.radians(90.0)
DENSITY_APART = 0.02  # relative: alloys of one number differ by less
SAME = 0.03  # relative: numbers of two reports about the same shot
# Ratios of walls and of spheres: at least, of a stronger shield; at least, of one that is not weaker.
STRONGER, EQUAL = 1.02, 0.999
# kg/m3: by the beginning of the alloy's name, from the material table of pyBLOSSUM (material_data.csv).
DENSITIES: Mapping[str, float] = {
    **{"AA99.9%": 2700.0, "AA1100": 2710.0, "AA2017": 2800.0, "AA2024": 2770.0, "AA2219": 2840.0, "AA3003": 2730.0},
    **{"AA5083": 2660.0, "AA5154": 2660.0, "AA5456": 2660.0, "AA6061": 2700.0, "AA7075": 2800.0, "Alclad 7075": 2800.0},
}
# A source whose outcomes contradict each other, as if they were the wrong way round: ``compared_pairs`` counts them.
IN_DOUBT = "AFML-TR-70-135"
CONTRADICTED = "of a source whose outcomes contradict each other"
SIZES = ("projectile_diameter", "bumper_thickness", "wall_thickness", "stand_off", "speed")
# A shield is like another where the root of the summed squares of ln ratios (bumper, wall, space, yield stress of the
# wall, densities) and of the angle in rad is no more: each ratio within 1.5 if all else is equal.
LIKE = 0.4
NEAR = 0.5  # of the distance: five numbers that differ by a quarter each
OTHER_METAL = 1.1  # ratio of densities: those of alloys of aluminium differ by less, those of other metals by more


@lru_cache(maxsize=256)
def aluminium(density: float, name: str = "") -> Material:
    """Aluminium of a density, kg/m3: equations of shields read no other constant of projectile and bumper."""
    return replace(load("al-6061-t6"), name=name or ALUMINIUM, density=density)


@dataclass(frozen=True, kw_only=True)
class ShieldShot:
    """A sphere that was shot at a shield of two aluminium walls, and whether the wall was perforated."""

    projectile_density: Annotated[KilogramPerCubicMetre, Described("density of the projectile")]
    projectile_diameter: Annotated[Metre, Described("diameter of the projectile")]
    speed: Annotated[MetrePerSecond, Described("impact speed")]
    obliquity: Annotated[Radian, Described("angle between the flight and the normal of the bumper")] = 0.0
    bumper_density: Annotated[KilogramPerCubicMetre, Described("density of the bumper")]
    bumper_thickness: Annotated[Metre, Described("thickness of the bumper")]
    stand_off: Annotated[Metre, Described("distance between bumper and wall")]
    wall_density: Annotated[KilogramPerCubicMetre, Described("density of the wall")]
    wall_yield_stress: Annotated[Pascal, Described("yield stress of the wall")]
    wall_thickness: Annotated[Metre, Described("thickness of the wall")]
    outcome: WallOutcome
    source: str = "own"  # a key of sources.csv, or what the user's table says
    shot: str = ""  # its number in the source
    projectile: str = ""
    bumper: str = ""
    wall: str = ""

    @property
    def is_perforated(self) -> bool:
        """Whether the wall failed."""
        return self.outcome == "perforated"

    @property
    def citation(self) -> str:
        """Its source in one line."""
        return citation(self.source)

    @property
    def normal_speed(self) -> float:
        """Component of the velocity along the bumper's normal, m/s."""
        return self.speed * math.cos(self.obliquity)

    @property
    def shield(self) -> Shield:
        """The shield."""
        return Shield(
            self.bumper_thickness, self.wall_thickness, self.stand_off, self.wall_yield_stress, self.wall_density
        )

    def as_shot(self) -> ShotAtShield:
        """The shot as laws take it."""
        return ShotAtShield(
            speed=self.speed,
            projectile_diameter=self.projectile_diameter,
            plate_thickness=self.bumper_thickness,
            projectile=aluminium(self.projectile_density, self.projectile),
            target=aluminium(self.bumper_density, self.bumper),
            obliquity=self.obliquity,
            shield=self.shield,
        )


@dataclass(frozen=True)
class Screening:
    """Shots that are used, and how many each rule has left out."""

    shots: tuple[ShieldShot, ...]
    left_out: Mapping[str, int]  # by rule


@dataclass(frozen=True)
class NearShot:
    """A shot with its distance from a shield and its projectile."""

    shot: ShieldShot
    distance: float


# --- reading ---------------------------------------------------------------------------------------


def read_shots(raw: object, path: str = PATH) -> tuple[ShieldShot, ...]:
    """The shots of a user's CSV text or list of mappings; raises InvalidInput with an error for each column.

    A column for each field of ``ShieldShot``, its unit in the heading, "speed [km/s]", or beside each number; those
    with a default may be left out, or empty. In the place of ``outcome`` a column ``perforated`` says yes or no, and
    either may say P or NP. Numbers that are impossible are refused.
    """
    columns = f"give {', '.join(declared(ShieldShot))}"
    rows = rows_of(raw, path, columns, WORDS)
    findings, shots = FindingsOfRows(path), list[ShieldShot]()
    words = {str(row.get(OUTCOME, "")).strip().upper() for _, row in rows}
    if "P" in words and "NP" not in words:
        raise refusal(f"{path}: {OUTCOME}", "P", "NP for some wall", "write perforated or held: P may stand for passed")
    for where, row in rows:
        with findings.of(where):
            shot = _read(row, where)
            findings.extend(
                where,
                (
                    Finding(where, reason, "a possible shot on aluminium walls", "correct the row, or remove it")
                    for reason in _impossible(shot)
                ),
            )
            shots.append(shot)
    findings.check()
    if not shots:
        raise refusal(path, "no shot", "at least one row", columns)
    return tuple(shots)


@cache
def collected() -> Screening:
    """The shots that ship, screened one by one: with the source in doubt."""
    text = files(__package__).joinpath("shots.csv").read_text(encoding="utf-8")
    cell = cache(partial(_cell, where=PATH))  # most numbers repeat: 0.05 s for 0.2 s (2026-11)
    rows = (row for _, row in rows_of(text, PATH, texts=WORDS))
    values = (dict(chain.from_iterable(cell(*item).items() for item in row.items())) for row in rows)
    return screened(nested(ShieldShot, of_shot) for of_shot in values)


@cache
def published() -> Screening:
    """The shots that ship and are used, screened."""
    all_shots = collected()
    kept = tuple(shot for shot in all_shots.shots if shot.source != IN_DOUBT)
    return Screening(kept, {**all_shots.left_out, CONTRADICTED: len(all_shots.shots) - len(kept)})


@cache
def sources() -> Mapping[str, Mapping[str, str]]:
    """Authors, year, title, publication, laboratory and note of each source, by its key."""
    text = files(__package__).joinpath("sources.csv").read_text(encoding="utf-8")
    return {row["source"]: row for row in csv.DictReader(text.splitlines())}


def citation(source: str) -> str:
    """A source in one line; the text itself where it is no key of sources.csv."""
    row = sources().get(source)
    if row is None:
        return source
    return ", ".join(part for part in (row["authors"], row["year"], row["title"], row["publication"]) if part)


def laboratory(shot: ShieldShot) -> str:
    """Where a shot was fired: of several reports one; the source where that is not known."""
    return sources().get(shot.source, {}).get("laboratory", shot.source)


def _read(row: Mapping[str, Plain], where: str) -> ShieldShot:
    findings, fields_of_shot = Findings(), declared(ShieldShot)
    values: dict[str, Value] = {}

    def read(heading: str, raw: Plain) -> None:
        value = _cell(heading, raw, where)
        for field in value.keys() & values:
            raise refusal(f"{where}.{field}", heading, "each column once", "remove one of the two")
        values.update(value)

    for item in row.items():
        findings.attempt(read, *item)
    if not findings:
        findings.extend(
            missing(parameter, where)
            for parameter in fields_of_shot.values()
            if parameter.required and parameter.name not in values
        )
    findings.check()
    return nested(ShieldShot, values)


def _cell(heading: str, raw: Plain, where: str) -> dict[str, Value]:
    """The field of a shot that a cell fills, with its value; an empty cell fills none."""
    fields_of_shot = declared(ShieldShot)
    name, unit = heading_of(heading, {*fields_of_shot, PERFORATED}, where)
    field = OUTCOME if name == PERFORATED else name
    if name == PERFORATED or (name == OUTCOME and str(raw).strip().upper() in ("P", "NP")):
        raw = OUTCOMES[not yes_or_no(raw, f"{where}.{name}")]
    if is_nothing(raw):
        return {}
    parameter = find(fields_of_shot, field, where)
    cell = str(raw) if name in NAMES else raw  # numbers of shots are names
    return {field: exact(parameter, cell, unit, f"{where}.{field}")[0]}


# --- screening -------------------------------------------------------------------------------------


def screened(shots: Iterable[ShieldShot]) -> Screening:
    """Shots without those that the rules leave out: impossible numbers, and the same shot in a second report.

    A shot is published twice where another source has one of its number and its outcome, all of whose numbers are
    within 3 %; the first is kept. Shots of one source that agree in everything but their number are repeats, and stay.
    """
    kept, left_out = list[ShieldShot](), Counter[str]()
    by_number: dict[str, list[ShieldShot]] = {}
    for shot in shots:
        same_number = by_number.setdefault(shot.shot, [])
        reasons = [*_impossible(shot), *("published twice" for other in same_number if _is_same(shot, other))]
        if reasons:
            left_out[reasons[0]] += 1
            continue
        kept.append(shot)
        same_number.append(shot)
    return Screening(tuple(kept), dict(left_out))


def _impossible(shot: ShieldShot) -> list[str]:
    """Why the numbers of a shot cannot be right."""
    roles = ("projectile", "bumper", "wall")
    unlike = [role for role in roles if _is_unlike(getattr(shot, role), getattr(shot, f"{role}_density"))]
    rules = {
        "a size that is not positive": min(getattr(shot, name) for name in SIZES) <= 0.0,
        "a yield stress that is not positive": shot.wall_yield_stress <= 0.0,
        f"a speed above {FASTEST / 1e3:g} km/s": shot.speed > FASTEST,
        "an obliquity that hits no plate": not 0.0 <= shot.obliquity < STEEPEST,
        "a density unlike that of its material": bool(unlike),
    }
    return [reason for reason, broken in rules.items() if broken]


def _is_unlike(material: str, density: float) -> bool:
    known = next((value for name, value in DENSITIES.items() if material.startswith(name)), None)
    return density <= 0.0 or (known is not None and not math.isclose(density, known, rel_tol=DENSITY_APART))


def _is_same(shot: ShieldShot, other: ShieldShot) -> bool:
    alike = shot.outcome == other.outcome and shot.source != other.source and shot.shot != ""
    numbers = [field.name for field in fields(ShieldShot) if isinstance(getattr(shot, field.name), float)]
    return alike and all(math.isclose(getattr(shot, name), getattr(other, name), rel_tol=SAME) for name in numbers)


def compared_pairs(shots: Sequence[ShieldShot]) -> tuple[int, int]:
    """How many pairs of shots of one source agree on what is stronger, and how many contradict it.

    Alloys and angle are the same, bumper, stand-off and speed within 3 %; one has a thicker wall or a smaller sphere,
    by 2 % or more, and neither the other way round. They agree where it held and the other was perforated, and
    contradict where it was perforated and the other held.
    """
    counts = Counter[bool]()
    for weak, strong in permutations(shots, 2):
        if weak.outcome != strong.outcome and _is_weaker(weak, strong):
            counts[weak.is_perforated] += 1
    return counts[True], counts[False]


def _is_weaker(one: ShieldShot, other: ShieldShot) -> bool:
    same = ("source", "obliquity", "projectile", "bumper", "wall")
    close = ("bumper_thickness", "stand_off", "speed")
    sphere = one.projectile_diameter / other.projectile_diameter
    wall = other.wall_thickness / one.wall_thickness
    return (
        all(getattr(one, name) == getattr(other, name) for name in same)
        and all(math.isclose(getattr(one, name), getattr(other, name), rel_tol=SAME) for name in close)
        and min(sphere, wall) >= EQUAL
        and max(sphere, wall) >= STRONGER
    )


# --- finding ---------------------------------------------------------------------------------------


def filtered(
    shots: Iterable[ShieldShot],
    within: Mapping[str, tuple[float, float]] | None = None,
    equal: Mapping[str, str] | None = None,
) -> tuple[ShieldShot, ...]:
    """Shots whose numbers (SI) lie within bounds, inclusive, and whose texts begin with those given; by field."""
    within, equal = within or {}, equal or {}
    return tuple(
        shot
        for shot in shots
        if all(low <= getattr(shot, name) <= high for name, (low, high) in within.items())
        and all(getattr(shot, name).startswith(text) for name, text in equal.items())
    )


def read_filters(raw: Sequence[str]) -> tuple[dict[str, tuple[float, float]], dict[str, str]]:
    """Bounds of numbers and beginnings of texts, as ``filtered`` takes them, of texts like "speed=6 km/s to 7 km/s".

    Raises InvalidInput with every finding.
    """
    within, equal, findings = dict[str, tuple[float, float]](), dict[str, str](), Findings()
    allowed = declared(ShieldShot)

    def read(text: str) -> None:
        name, _, value = (part.strip() for part in text.partition("="))
        parameter = find(allowed, name, "where")
        if parameter.unit is None:
            equal[name] = value
            return
        low, _, high = value.partition(TO)
        bounds = [parse_value(parameter, end, f"where.{name}") for end in (low, high or low)]
        within[name] = (float(bounds[0] or 0.0), float(bounds[1] or 0.0))

    for text in raw:
        findings.attempt(read, text)
    findings.check()
    return within, equal


def nearest(shot: ShotAtShield, shots: Sequence[ShieldShot], count: int) -> tuple[NearShot, ...]:
    """The shots on the same metals that are nearest to a shot on a shield, by their distance.

    The distance is the root of the sum of squares of ln of the ratios of d, t_b, t_w, S, v, the densities and the yield
    stress of the wall, and of the difference of the angles in rad. Logarithms, because the equations are products of
    powers, so that a ratio counts the same for a foil as for a plate; no weights, because the equations do not agree on
    the powers. Of another metal is what has a density more than a tenth apart.
    """
    pairs = zip(shots, distances(shot, shots), strict=True)
    near = (NearShot(other, distance) for other, distance in pairs if math.isfinite(distance))
    return tuple(sorted(near, key=lambda other: other.distance)[:count])


def distances(shot: ShotAtShield, shots: Sequence[ShieldShot]) -> list[float]:
    """The distance of each shot from a shot on a shield; infinite where a metal is another, or its strength unknown."""
    return [_distance(_place(shot), _place(other.as_shot())) for other in shots]


def like_shields(shot: ShotAtShield) -> list[ShieldShot]:
    """The published shots on shields like that of a shot, at any speed and of any diameter; all have one bumper."""
    if shot.shield.further_bumpers:
        return []
    shots = published().shots
    return [like for like, apart in zip(shots, distances_of_shields(shot, shots), strict=True) if apart <= LIKE]


def distances_of_shields(shot: ShotAtShield, shots: Sequence[ShieldShot]) -> list[float]:
    """The distances without the ratios of diameter and speed: how far the shields and the metals are apart."""
    return [_distance(_place(shot)[2:], _place(other.as_shot())[2:]) for other in shots]


def _place(shot: ShotAtShield) -> tuple[float, ...]:
    """What the distance of two shots is of: ln of diameter, speed, four numbers of the shield, densities; the angle."""
    shield = shot.shield
    sizes = (shield.bumper_thickness, shield.wall_thickness, shield.stand_off, shield.wall_yield_stress)
    densities = (shot.projectile.density, shot.target.density, shield.wall_density or shot.target.density)
    return *map(math.log, (shot.projectile_diameter, shot.speed, *sizes, *densities)), shot.obliquity


def _distance(one: Sequence[float], other: Sequence[float]) -> float:
    densities = [abs(a - b) for a, b in zip(one[-4:-1], other[-4:-1], strict=True)]
    distance = math.dist(one, other)
    return math.inf if max(densities) > math.log(OTHER_METAL) or math.isnan(distance) else distance
