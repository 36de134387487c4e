"""What every law says of each shot of a question, how far apart they are, and the published shots nearest to it."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache

from pydantic_core import from_json, to_json

from studies import laws, materials
from studies.answers.question import Question
from studies.answers.targets import Addition, targets
from studies.laws import Law, RangeStatus, Shot, unmeasured
from studies.observations import UNKNOWN_ALLOY, Observation, written_bounds
from studies.quantities.display import NONE, digits, display_of
from studies.quantities.parameters import Plain, Value
from studies.quantities.units import readable
from studies.sweeps.reading import published_shots

UNITS = {1: "m", 2: "m2", 3: "m3"}  # of a quantity by its dimension in lengths
NEAREST = 5  # shots that an answer lists


@dataclass(frozen=True)
class LawAnswer:
    """One law about one shot."""

    law: Law
    value: float  # SI; NaN where the law means nothing, with the reason
    low: float  # over the law's stated variants
    high: float
    in_range: bool
    status: RangeStatus  # how it stands to its range
    outside: str  # by which limits it is outside, and by how much; or why it has no value

    @property
    def is_for_another_material(self) -> bool:
        """Whether the law was fitted to targets of another metal."""
        return self.status is RangeStatus.OTHER_MATERIAL

    def printed(self, unit: str) -> str:
        """Its value in the display unit of an SI unit, or its bounds where it has variants; a dash of none."""
        return printed_bounds(self.low, self.high, unit)

    def describe(self) -> dict[str, Plain]:
        """Plain values, SI."""
        numbers = {"value": self.value, "low": self.low, "high": self.high}
        range_of: dict[str, Plain] = {"in_range": self.in_range, "range_status": self.status, "outside": self.outside}
        return {"law": self.law.name, **_plain(numbers), **range_of}


@dataclass(frozen=True)
class QuantityAnswer:
    """Every law of one quantity about one shot."""

    quantity: str
    unit: str  # SI
    laws: tuple[LawAnswer, ...]

    @property
    def title(self) -> str:
        """Its name in words."""
        return unmeasured().get(self.quantity, self.quantity.replace("_", " ").capitalize())

    @property
    def trusted(self) -> list[LawAnswer]:
        """The laws whose range holds the shot and whose confidence lets them judge."""
        return [answer for answer in self.laws if answer.in_range and answer.law.use == "verdict"]

    @property
    def spread(self) -> tuple[float, float] | None:
        """Smallest and largest value of the laws in range; None where there is none."""
        values = [bound for law in self.trusted for bound in (law.low, law.high) if not math.isnan(bound)]
        return (min(values), max(values)) if values else None

    def describe(self) -> dict[str, Plain]:
        """Plain values."""
        spread = self.spread
        return {
            "quantity": self.quantity,
            "title": self.title,
            "unit": self.unit,
            "laws": [answer.describe() for answer in self.laws],
            "spread": spread and {"low": spread[0], "high": spread[1], "laws": len(self.trusted)},
        }

    def sentence(self) -> str:
        """What the laws say, in a sentence of at most twenty words."""
        count, spread = len(self.trusted), self.spread
        if spread is None:
            return f"{self.title}: no law in range."
        law = self.trusted[0].law.title if count == 1 else f"{count} laws in range"
        return f"{self.title}: {printed_bounds(*spread, self.unit)} {display_of(self.unit).unit} ({law})."


@dataclass(frozen=True)
class NearObservation:
    """A published shot near that of a question."""

    shot: Observation
    apart: float  # root of the summed squares of ln ratios of speed, diameter and thickness over diameter

    def printed(self) -> str:
        """What was measured, with its unit: "14 mm", or "27.5 mm to 34.5 mm"."""
        if self.shot.bounds is not None:
            return written_bounds(self.shot.bounds, "m")
        return readable(self.shot.value or 0.0, "m")

    def describe(self) -> dict[str, Plain]:
        """Plain values, SI."""
        names = ("quantity", "value", "bounds", "uncertainty", "parameters", "source", "confidence", "note")
        plain: dict[str, Plain] = {name: getattr(self.shot, name) for name in names}
        stated = {name: value for name, value in self.shot.parameters.items() if value is not None}
        return {**plain, "parameters": stated, "apart": self.apart}


@dataclass(frozen=True)
class ShotAnswer:
    """What laws and shots say of one shot."""

    parameters: Mapping[str, Value]  # of the shot, SI
    target: str  # a name of ``targets``
    quantities: tuple[QuantityAnswer, ...]
    shots: tuple[NearObservation, ...]  # of the tables of its target
    addition: Addition | None  # what its target says besides

    def describe(self) -> dict[str, Plain]:
        """Plain values, SI, for a program; the addition of a target stands under its name."""
        additions: dict[str, Plain] = {name: None for name, target in targets().items() if target.adds}
        if self.addition:
            additions[self.target] = {**_plain(self.addition), "sentence": self.addition.sentence}
        return {
            "headline": self.headline(),
            "parameters": {name: value for name, value in self.parameters.items() if value is not None},
            "quantities": [quantity.describe() for quantity in self.quantities],
            "shots": [shot.describe() for shot in self.shots],
            **additions,
        }

    def headline(self) -> str:
        """What comes first, in at most twenty words: what the target adds, or the first quantity."""
        return self.addition.sentence if self.addition else self.quantities[0].sentence()


def document(question: Question) -> dict[str, Plain]:
    """The answers to a question as plain values, SI, with what the catalogue says of each law once."""
    items = list(answers(question))
    asked = {answer.law.name: answer.law for quantity in items[0].quantities for answer in quantity.laws}
    return {
        "target": question.target,
        "axes": {axis.name: {"unit": axis.unit, "values": list(axis.values)} for axis in question.axes},
        "laws": {name: law.describe() for name, law in asked.items()},
        "items": [item.describe() for item in items],
    }


def answers(question: Question) -> Iterator[ShotAnswer]:
    """The answer to each shot of a question, the last axis fastest."""
    for point in question.points():
        yield answer(question.shot(point), question.target, point)


def answer(shot: Shot, target: str, parameters: Mapping[str, Value]) -> ShotAnswer:
    """The answer to one shot."""
    near, addition = tuple(nearest(shot, target)), targets()[target].addition
    return ShotAnswer(
        parameters, target, tuple(_quantities(shot, target)), near, addition.of(shot) if addition else None
    )


def _quantities(shot: Shot, target: str) -> Iterator[QuantityAnswer]:
    for quantity in targets()[target].quantities:
        if asked := laws.answering(quantity):
            ranked = sorted((ask(law, shot) for law in asked), key=_rank)
            yield QuantityAnswer(quantity, UNITS[asked[0].dimension], tuple(ranked))


def ask(law: Law, shot: Shot) -> LawAnswer:
    """What a law says of a shot: the middle of its variants, and their bounds."""
    first = law.evaluate(shot, law.variants(shot)[0])
    low, high = law.band(shot)
    return LawAnswer(law, 0.5 * (low + high), low, high, first.in_range, first.status, laws.in_words(first.reasons))


def _rank(answer: LawAnswer) -> tuple[bool, bool, bool, str]:
    return math.isnan(answer.value), not answer.in_range, answer.law.use != "verdict", answer.law.name


def shot_in_words(shot: Shot) -> str:
    """What hits what, in a line."""
    parts = [f"{shot.projectile.name} {readable(shot.projectile_diameter, 'm')}, {readable(shot.speed, 'm s-1')}"]
    if shot.plate_thickness is not None:
        parts.append(f"{shot.target.name} {readable(shot.plate_thickness, 'm')}")
    sizes = (size for target in targets().values() for size in target.sizes(shot))
    parts += (f"{word} {readable(size, 'm')}".strip() for word, size in sizes)
    if shot.obliquity:
        parts.append(readable(shot.obliquity, "rad"))
    return " | ".join(parts)


# --- published shots --------------------------------------------------------------------------------


def nearest(shot: Shot, target: str, count: int = NEAREST) -> list[NearObservation]:
    """The published shots of the same metals nearest to one: by speed, diameter and thickness over diameter."""
    near = []
    for published in _published(target):
        p = published.parameters
        metals = _family(p.get("projectile")), _family(p.get("target"))
        if metals == (shot.projectile.family, shot.target.family):
            speed, diameter = float(p["speed"] or 0.0), float(p["projectile_diameter"] or 0.0)
            ratios = [speed / shot.speed, diameter / shot.projectile_diameter]
            if shot.plate_thickness and p.get("plate_thickness"):
                ratios.append(float(p["plate_thickness"] or 0.0) / diameter / shot.thickness_ratio)
            near.append(NearObservation(published, math.hypot(*map(math.log, ratios))))
    return sorted(near, key=lambda seen: seen.apart)[:count]


@cache
def _published(target: str) -> Sequence[Observation]:
    table = targets()[target].table
    return published_shots(*table) if table else ()


def _family(material: Value) -> str:
    """The metal of a published shot, which may name no alloy."""
    name = str(material)
    return name.removesuffix(UNKNOWN_ALLOY) if name.endswith(UNKNOWN_ALLOY) else materials.load(name).family


def printed_bounds(low: float, high: float, unit: str) -> str:
    """Two bounds in the display unit of an SI unit, as one number where they print alike; a dash of NaN.

    >>> [printed_bounds(low, high, "m") for low, high in ((0.0212, 0.0234), (0.0212, 0.0212), (math.nan, math.nan))]
    ['21.2 to 23.4', '21.2', '–']
    """
    if math.isnan(low):
        return NONE
    texts = [digits(bound * display_of(unit).factor) for bound in (low, high)]
    return texts[0] if texts[0] == texts[1] else " to ".join(texts)


def _plain(value: object) -> dict[str, Plain]:
    """A record or a mapping as JSON has it: None in place of NaN."""
    return dict(from_json(to_json(value, inf_nan_mode="null")))
