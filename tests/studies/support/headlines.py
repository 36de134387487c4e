"""What a headline says, beside the numbers of the same cube: differences, error bars and exponents computed anew."""

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from scipy import stats

from studies.cubes import reading
from studies.cubes.points import places_of, points_of
from studies.laws import DRAWN_ONLY, FITTED
from studies.quantities.display import display_of
from studies.reports.matched import matched_observations

MOST_WORDS, MOST_REJECTING, CLOSE = 20, 0.2, 0.10
FIRST_HAND = ("", "read", "verified", "user")
DIFFERENCE = r"no difference|[\d.]+ % low to [\d.]+ % high|(?:[\d.]+ to )?[\d.]+ % (?:low|high)"
BAR = r"±(?:[\d.]+ % numerically, ±)?(?P<bar>[\d.]+) %(?: with models)?"  # joint
FORMS = (
    rf"(?P<place>.+?): use (?P<names>.+), (?P<difference>{DIFFERENCE}), {BAR}",
    rf"(?P<place>.+?): (?P<names>.+) agrees? only to {BAR}: (?P<difference>{DIFFERENCE})",
    rf"(?P<place>.+?): trust none; (?P<nearest>nearest )?(?P<names>.+?),? (?:is )?(?P<difference>{DIFFERENCE})"
    r"(?:, (?P<rejecting>\d+) of (?P<tested>\d+) points reject|, the one point rejects)?",
    r"(?P<place>.+?): trust none; the exponent of (?:every law|its one law) is refuted",
    rf"(?P<place>.+?): untested; (?P<names>.+), (?P<difference>{DIFFERENCE})",
    rf"(?P<place>.+?): (?P<names>.+), (?P<difference>{DIFFERENCE}), {BAR}",
)
ELSEWHERE = rf"(?:; elsewhere (?P<elsewhere>{DIFFERENCE}))?(?:;|,) (?P<by>.+)\."


@dataclass(frozen=True)
class Judged:
    """A law beside a reference at one point."""

    law: str
    judge: str  # "simulation", "shots", "doubtful"
    at: Mapping[str, Any]
    value: float
    reference: float
    bar: float  # joint uncertainty over the reference
    tests: bool

    @property
    def residual(self) -> float:
        return self.value / self.reference - 1.0

    @property
    def rejects(self) -> bool:
        return self.tests and abs(self.residual) > self.bar

    @property
    def contradicts(self) -> bool:
        return abs(self.residual) > max(self.bar, CLOSE)


def judged_in(cube: xr.Dataset, name: str) -> list[Judged]:
    """Every point of a cube that judges a law of a quantity, by arithmetic on its arrays."""
    points = points_of(cube)
    return [*_by_simulation(points, name), *_by_shots(points, name)] if f"{name}_by_law" in points else []


def _by_simulation(points: xr.Dataset, name: str) -> Iterator[Judged]:
    value = points[name].where(points.run_state == 0)
    flagged = (reading.doubts(points[f"{name}_flags"]) != 0) | (points.run_flags != 0)
    parts = [points[f"{name}_reading_uncertainty"]]
    parts += [points[part] for part in (f"{name}_definition_part", f"{name}_model_part") if part in points]
    mesh = f"{name}_converged_uncertainty_mesh"
    tests = points[mesh].notnull() if mesh in points else xr.zeros_like(value, dtype=bool)
    usable = value.notnull() & ~flagged & (value != 0.0)
    squares = sum(part.fillna(0.0) ** 2 for part in parts)
    law = f"{name}_law"
    for number, label in enumerate(points[law].values):
        if _is_drawn_only(points[f"{law}_confidence"].values[number]):
            continue
        answers, inside = (points[each].isel({law: number}) for each in (f"{name}_by_law", f"{name}_by_law_in_range"))
        spread = float(np.nan_to_num(points[f"{law}_scatter"].values[number])) * answers
        bar = (squares + spread**2) ** 0.5 / abs(value)
        judges = usable & (inside == 1) & answers.notnull()
        columns = [each.broadcast_like(value).values.ravel() for each in (answers, value, bar, tests, judges)]
        for at, answer, reference, width, tested, judged in zip(places_of(points), *columns, strict=True):
            if judged:
                yield Judged(str(label), "simulation", at, answer, reference, width, bool(tested))


def _is_drawn_only(confidence: str) -> bool:
    """Whether a law is in no verdict by the confidence in its equation, of "equation: memory"."""
    return re.split("[:;] ?", str(confidence))[1] in DRAWN_ONLY


def _by_shots(points: xr.Dataset, name: str) -> Iterator[Judged]:
    at_shots = f"{name}_by_law_at_observation"
    if at_shots not in points:
        return
    law = str(points[at_shots].dims[-1])
    labels, confidences = (points[each].values.astype(str) for each in (law, f"{name}_observed_law_confidence"))
    scatters = dict(zip(points[f"{name}_law"].values.astype(str), points[f"{name}_law_scatter"].values, strict=True))
    for shot in matched_observations(points, name):
        row = points.isel(observation=shot.observation)
        observed = float(row[f"{name}_observed"])
        stated = float(row[f"{name}_observed_uncertainty"])
        judge = "shots" if shot.confidence in FIRST_HAND else "doubtful"
        for number, label in enumerate(labels):
            answer = float(row[at_shots].values[number])
            inside = row[f"{at_shots}_in_range"].values[number] == 1
            reason = str(row[f"{at_shots}_reason"].values[number])
            ok = shot.is_alike and inside and math.isfinite(answer) and observed and reason != FITTED
            if ok and not _is_drawn_only(confidences[number]):
                spread = float(np.nan_to_num(scatters.get(label, 0.0))) * answer
                bar = math.hypot(np.nan_to_num(stated), spread) / abs(observed)
                yield Judged(label, judge, shot.at, answer, observed, bar, math.isfinite(stated))


def is_refuted(points: Sequence[Judged]) -> bool:
    """Whether an exponent of a law is outside of the interval of that of the reference, in any slice of any axis."""
    axes = [key for key, value in points[0].at.items() if isinstance(value, float) and key in AXES]
    for axis in axes:
        slices: dict[Any, list[Judged]] = {}
        for point in points:
            slices.setdefault(tuple(point.at.get(other) for other in axes if other != axis), []).append(point)
        for mine in slices.values():
            x = np.log([point.at[axis] for point in mine])
            if len(set(x)) < 3:
                continue
            y, law = (np.log([getattr(point, key) for point in mine]) for key in ("reference", "value"))
            fit = stats.linregress(x, y)
            bars = np.array([point.bar for point in mine])
            leverage = (x - x.mean()) / ((x - x.mean()) ** 2).sum()
            reach = math.hypot(stats.t.ppf(0.975, len(x) - 2) * fit.stderr, math.sqrt(((leverage * bars) ** 2).sum()))
            if abs(np.polyfit(x, law, 1)[0] - fit.slope) > reach + 1e-6:
                return True
    return False


AXES = ("speed", "plate_thickness", "projectile_diameter")


def ends_of(text: str) -> tuple[float, float]:
    """The ends of a difference in words, in per cent."""
    numbers = [float(each) for each in re.findall(r"[\d.]+", text)]
    if not numbers:
        return 0.0, 0.0
    if "low to" in text:
        return -numbers[0], numbers[1]
    low, high = min(numbers), max(numbers)
    return (-high, -low) if text.endswith("low") else (low, high)


def agrees(text: str, points: Sequence[Judged]) -> bool:
    """Whether a difference in words is that of some points, to the digit that is printed."""
    residuals = [100.0 * point.residual for point in points]
    return all(
        abs(said - true) <= (0.501 if abs(true) >= 0.949 else 0.0501)
        for said, true in zip(ends_of(text), (min(residuals), max(residuals)), strict=True)
    )


def holds(points: Sequence[Judged], refuted: bool) -> bool:
    """Whether a law may be trusted at some points."""
    tested = [point for point in points if point.tests]
    few = sum(point.rejects for point in tested) <= MOST_REJECTING * len(tested)
    return few and not refuted and not any(point.contradicts for point in points)


def untruths(document: Mapping[str, Any], cube: xr.Dataset) -> list[str]:
    """What is wrong with the headline of a report, by the cube of the same sweep."""
    text = document["headline"]
    if len(text.split()) > MOST_WORDS:
        return [f"{len(text.split())} words: {text}"]
    laws = document["verdict"]["quantities"]
    every = {each["quantity"]: judged_in(cube, each["quantity"]) for each in laws}
    text = text.replace("\u202f", " ")
    if text.startswith("No verdict"):
        return [f"a law is judged: {text}"] if any(every.values()) else []
    if document["methods"] and " beside " in text:
        return list(_of_methods(text, cube))
    if not document["limits"] and all(law["subject"] == "simulation" for each in laws for law in each["laws"]):
        return list(_of_values(text, cube))
    wrong = [] if any(every.values()) or document["limits"] else [f"nothing judges a law: {text}"]
    return wrong or list(_untruths(text, laws[0], every[laws[0]["quantity"]])) if laws else wrong


def _of_values(text: str, cube: xr.Dataset) -> Iterator[str]:
    """Values of quantities beside those of the points that succeeded."""
    points = points_of(cube)
    parts = re.split(r", (?![^(]*\))", text.rstrip(".").partition(";")[0])
    for part in [each for each in parts if not each.endswith("run")]:
        part, _, beside = part.partition(" (")
        words = re.match(r"(.+?) (−?\d[\d ]*[\d.·⁻⁰-⁹¹²³]*)(?:(?:-| to )(−?[\d.·⁻⁰-⁹¹²³ ]+))? ?(\D.*)?$", part)
        names = (
            []
            if words is None
            else [words[1].lower().replace(" ", "_"), f"{words[1].lower().replace(' ', '_')}_percent"]
        )
        name = next((name for name in names if name in points), None)
        if words is None or name is None:
            yield f"unknown quantity: {part}"
            continue
        values = points[name].where(points.run_state == 0) * display_of(points[name].attrs["units"]).factor
        said = [_number(words[2]), _number(words[3] or words[2])]
        if not np.allclose(said, [float(values.min()), float(values.max())], rtol=6e-3, atol=6e-4):
            yield f"another value: {part}, not {float(values.min())} to {float(values.max())}"
        if beside:
            yield from _of_own_shots(beside.rstrip(")"), points, name)


def _of_own_shots(text: str, points: xr.Dataset, name: str) -> Iterator[str]:
    """What is said of a quantity beside its shots, in a sweep over one axis."""
    said, _, count = text.rpartition(", ")
    (axis,) = points[name].dims
    observed = points[f"{name}_observed"].values
    simulated = np.interp(points[f"observation_{axis}"].values, points[axis].values, points[name].values)
    shares = [float(share) for share in simulated / observed - 1.0 if math.isfinite(share)]
    if count.split() != [str(len(shares)), "shot" if len(shares) == 1 else "shots"]:
        yield f"another number of shots: {text}, {shares}"
    if not agrees(said, [Judged("", "", {}, 1.0 + share, 1.0, 0.0, False) for share in shares]):
        yield f"the difference to shots is another: {text}, {shares}"


def _number(text: str) -> float:
    """A printed number: "−1.2", "48 260", "9.5·10⁻⁴"."""
    raised = str.maketrans("−⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "--0123456789")
    return float(text.replace(" ", "").translate(raised).replace("·10", "e"))


def _of_methods(text: str, cube: xr.Dataset) -> Iterator[str]:
    """What methods change beside the first one."""
    said = re.match(rf"(.+?)(?: by .+?)?: ({DIFFERENCE}), beside (\S+);", text)
    name = "" if said is None else said[1].lower().replace(" ", "_")
    if said is None or name not in cube:
        yield f"unknown form: {text}"
        return
    values = cube[name].where(cube.run_state == 0)
    by_method = {str(method): values.isel({values.dims[0]: place}) for place, method in enumerate(cube.method.values)}
    shares = [float(value / by_method[said[3]]) - 1.0 for method, value in by_method.items() if method != said[3]]
    residuals = [Judged("", "", {}, 1.0 + share, 1.0, 0.0, False) for share in shares if math.isfinite(share)]
    if not agrees(said[2], residuals):
        yield f"the difference is another: {text}, {shares}"


def _untruths(text: str, quantity: Mapping[str, Any], every: Sequence[Judged]) -> Iterator[str]:
    said = next(filter(None, (re.fullmatch(form + ELSEWHERE, text) for form in FORMS)), None)
    if said is None:
        yield f"unknown form: {text}"
        return
    groups = said.groupdict()
    judge = next(judge for judge in ("shots", "simulation", "doubtful") if any(each.judge == judge for each in every))
    mine = [point for point in every if point.judge == judge]
    if (judge == "simulation") == ("simulation" not in said["by"]) or (judge == "shots") != bool(
        re.search(r"^(no error stated, )?(one|two|three|\d+) shots?", said["by"])
    ):
        yield f"judged by {judge}: {text}"
    by_law: dict[str, list[Judged]] = {}
    for point in mine:
        by_law.setdefault(point.law, []).append(point)
    refuted = {
        law: any(point.tests for point in points) and is_refuted(_exponents(law, points, every))
        for law, points in by_law.items()
    }
    standing = {law: _at(groups["place"], points) for law, points in by_law.items()}
    if groups.get("names") is None:
        if not all(refuted.values()):
            yield f"not every exponent is refuted: {text}"
        return
    rows = quantity["rows"]
    first = quantity["laws"]
    labels = _labels(groups["names"], first, rows)
    points = [point for law in labels for point in standing[law]]
    if any(refuted[law] for law in labels) and judge != "doubtful":
        yield f"an exponent is refuted: {text}"
    if not agrees(groups["difference"], points):
        yield f"the difference is another: {text}"
    if groups["elsewhere"]:
        rest = [point for point in by_law[labels[0]] if point not in standing[labels[0]]]
        if not rest or not agrees(groups["elsewhere"], rest):
            yield f"elsewhere it is another: {text}"
    tested = [point for point in points if point.tests]
    if groups.get("bar") and abs(float(groups["bar"]) - 100.0 * max(point.bar for point in tested)) > 0.501:
        yield f"the error bar is another: {text}"
    if "trust none" in text:
        if judge != "doubtful" and any(holds(points, refuted[law]) for law, points in by_law.items()):
            yield f"a law holds: {text}"
        if groups["rejecting"] and [int(groups["rejecting"]), int(groups["tested"])] != [
            sum(point.rejects for point in tested),
            len(tested),
        ]:
            yield f"other points reject: {text}"
    elif not all(holds(standing[law], refuted[law]) for law in labels):
        yield f"a law does not hold there: {text}"
    if judge == "doubtful" and "trust none" not in text:
        yield f"doubtful shots recommend: {text}"
    if ": use " in text and not all(max(abs(point.residual), point.bar) <= CLOSE for point in points):
        yield f"a bar or a difference is above {CLOSE}: {text}"
    if ("untested" in text) != (2 * len(tested) <= len(points)) and "trust none" not in text:
        yield f"tested at {len(tested)} of {len(points)}: {text}"
    if len(labels) == 1 and rows[0]["difference"].replace("\u202f", " ") != groups["difference"]:
        yield f"the table has another number: {rows[0]['difference']}; {text}"


def _exponents(law: str, mine: Sequence[Judged], every: Sequence[Judged]) -> Sequence[Judged]:
    """The points that tell the exponents of a law: those that judge, else those of the simulation."""
    speeds = {point.at.get("speed") for point in mine}
    others = [point for point in every if point.law == law and point.judge == "simulation"]
    return mine if len(speeds) >= 3 or not others else others


def _at(place: str, points: Sequence[Judged]) -> list[Judged]:
    """The points at a place of a headline: "2-7 km/s", "depth 4 km/s"."""
    found = re.search(r"([\d.]+)(?:-([\d.]+))? (\S+)$", place)
    axis = "speed" if place.endswith("km/s") else None
    if found is None or axis is None:
        return list(points)
    factor = display_of("m s-1").factor
    low, high = float(found[1]), float(found[2] or found[1])
    return [point for point in points if 0.999 * low <= factor * point.at["speed"] <= 1.001 * high]


def _labels(names: str, laws: Sequence[Mapping[str, Any]], rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """The laws that a headline names, or counts: then the first of its table."""
    counted = re.fullmatch(r"(two|three|\d+) laws", names)
    if counted:
        count = {"two": 2, "three": 3}.get(counted[1]) or int(counted[1])
        named = list(dict.fromkeys(row["law"] for row in rows))[:count]
    else:
        named = [
            row["law"]
            for row in rows
            if re.search(rf"(^|, | or | and ){re.escape(row['law'])}(, | or | and |$)", names)
        ]
        named = [
            name for name in named if not any(name != other and name in other and names == other for other in named)
        ]
    judged = [law for law in laws if law["subject"] != "simulation" and law["judged"]]
    found = []
    for name in dict.fromkeys(named or [names]):
        mine = [law["subject"] for law in judged if name in (law["subject"], law["title"])]
        mine = mine or [
            law["subject"] for law in judged if f"{law['title']} ({law['subject'].partition('/')[2]})" == name
        ]
        found.append((mine or [law["subject"] for law in judged if law["title"].startswith(name)])[0])
    return found
