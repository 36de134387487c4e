"""What a designer asks of a shield: does it hold, how sure is that, and what did real shots do."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from solver.units import Metre
from studies import laws
from studies.answers.targets import Addition, Told, Variable, Variables
from studies.laws import Shot
from studies.quantities.display import digits, display_of, percent
from studies.shields.shield import CRITICAL_DIAMETER, ShotAtShield
from studies.shields.shots.chance import probability
from studies.shields.shots.inverse import RISKS, safe_sizes
from studies.shields.shots.judged import Judged, equations, judge
from studies.shields.shots.outside import outside_of_shots
from studies.shields.shots.records import NoSize, Probability, SafeSize, Size
from studies.shields.shots.table import EQUAL, NEAR, NearShot, ShieldShot, nearest, published

# What the field calls the equations, in a sentence.
SHORT: Mapping[str, str] = {
    "whipple_nno": "NNO",
    "whipple_nno_modified": "modNNO",
    "whipple_jsc": "JSC",
    "whipple_reimerdes": "Reimerdes",
    "whipple_srl": "SRL",
    "whipple_srl_three_walls": "SRL, three walls",
}
LAWS = f"{CRITICAL_DIAMETER}_law"  # a dimension
NO_EQUATION = SafeSize(Size.SPHERE, None, None, None, NoSize.NO_EQUATION)
# Of the sizes that are just safe.
COLUMNS = ("still safe", "largest sphere (mm)", "thinnest wall (mm)", "shortest stand-off (mm)")
REASONS: Mapping[NoSize, str] = {
    NoSize.SAFE: "any",
    NoSize.UNSAFE: "none",
    NoSize.OUTSIDE_OF_SHOTS: "no shots like it",
    NoSize.NO_EQUATION: "no equation",
}
LISTED = 10  # nearest shots of an answer


@dataclass(frozen=True)
class Word:
    """What an equation says of a shield and a projectile."""

    law: str
    says: Literal["holds", "fails", "outside"]
    critical_diameter: Metre  # NaN where the equation has none
    reason: str  # why the shot is outside the equation's range; empty inside

    @property
    def short(self) -> str:
        """The equation's short name."""
        return SHORT.get(self.law, laws.load(self.law).title)


@dataclass(frozen=True)
class Ordered:
    """The published shots on the same metals that are easier than one in every respect, or harder."""

    shots: int
    contrary: int  # of these: easier and failed, or harder and held
    nearest: tuple[NearShot, ...]  # contrary shots, the one most like the question first


@dataclass(frozen=True)
class ShieldAnswer(Addition):
    """The probability that a wall is perforated, what each equation says, and the shots near it."""

    probability: Probability | None  # None outside of all shots, and where no equation covers the shot
    words: tuple[Word, ...]
    near: int  # number of shots within the distance NEAR
    nearest: tuple[NearShot, ...]
    judged: tuple[Judged, ...]  # each equation by the shots that are near
    outside: tuple[str, ...]  # why the shield lies outside of all shots; empty inside
    easier: Ordered
    harder: Ordered
    safe: tuple[SafeSize, ...]  # the largest sphere, thinnest wall and shortest stand-off

    @property
    def sentence(self) -> str:
        """The answer in at most 20 words."""
        if self.probability is None:
            sure = f"no probability: {self.outside[0]}" if self.outside else "no probability"
        else:
            near = f"{self.near} {'shot' if self.near == 1 else 'shots'} near"
            sure = f"{shown(self.probability)} to fail; {near}"
        return f"{sure}; {self._said() or 'no equation covers it'}."

    @property
    def told(self) -> Told:
        """The sentence, what has no probability and why, ordered shots; and the sizes that are just safe."""
        unlikely = (f"no probability: {reason}" for reason in self.outside[1:])
        found = {(limit_in_words(safe), safe.size): size_in_words(safe) for safe in self.safe}
        rows = ((limit, *(found[limit, size] for size in Size)) for limit in dict.fromkeys(limit for limit, _ in found))
        return Told((self.sentence, *unlikely, self.ordered_shots), COLUMNS, tuple(rows))

    @property
    def ordered_shots(self) -> str:
        """ "In every respect: 2 of 14 easier shots failed; no published shot is harder."."""
        kinds = (("easier", "failed", self.easier), ("harder", "held", self.harder))
        said = [
            f"{shots.contrary} of {shots.shots} {kind} shots {did}" if shots.shots else f"no published shot is {kind}"
            for kind, did, shots in kinds
        ]
        return f"In every respect: {'; '.join(said)}."

    @classmethod
    def of(cls, shot: Shot) -> "ShieldAnswer":
        """What is said of a shot at a shield."""
        assert isinstance(shot, ShotAtShield)
        return answer(shot)

    @staticmethod
    def variables(  # type: ignore[override]  # its own additions
        shields: "Sequence[ShieldAnswer]", axes: tuple[str, ...], lengths: tuple[int, ...]
    ) -> tuple[Variables, Variables]:
        """The probability to fail, the easier shots that failed, the harder ones that held, and the safe sizes."""
        variables = dict[str, Variable]()
        equations = [law.name for law in laws.answering(CRITICAL_DIAMETER)]

        def add(
            name: str, title: str, unit: str, values: Sequence[float] | Sequence[str], dims: tuple[str, ...] = ()
        ) -> None:
            shape = (len(values) // len(shields), *lengths) if dims else lengths
            variables[name] = ((*dims, *axes), np.array(values).reshape(shape), {"units": unit, "long_name": title})

        for part, end in (("value", ""), ("low", "_low"), ("high", "_high")):
            chances = [getattr(shield.probability, part, math.nan) for shield in shields]
            add(f"probability{end}", "Probability that the wall fails", "1", chances)
        add("easier_failed", "Easier shots whose wall failed", "1", [shield.easier.contrary for shield in shields])
        add("harder_held", "Harder shots whose wall held", "1", [shield.harder.contrary for shield in shields])
        found = [{(safe.size, safe.risk or safe.law): safe for safe in shield.safe} for shield in shields]
        for size in Size:
            for dim, by, limits in (("risk", "risk", RISKS), (LAWS, "law", equations)):
                sizes = [safe.get((size, limit), NO_EQUATION) for limit in limits for safe in found]
                name, title = f"safe_{size}_by_{by}", f"{size.replace('_', ' ')} that is just safe"
                add(name, title, "m", [math.nan if safe.value is None else safe.value for safe in sizes], (dim,))
                add(f"{name}_reason", "why there is none", "1", [str(safe.reason or "") for safe in sizes], (dim,))
        return {"risk": ("risk", list(RISKS), {"units": "1"})}, variables

    def _said(self) -> str:
        """What the equations say, those of one word together; those outside their range are silent."""
        groups = {says: [word.short for word in self.words if word.says == says] for says in ("holds", "fails")}
        spoken = [(says, names) for says, names in groups.items() if names]
        verbs = ("say " if len(names) > 1 else "says " for _, names in spoken[:1])
        return ", ".join(f"{', '.join(names)} {next(verbs, '')}{says}" for says, names in spoken)


def limit_in_words(safe: SafeSize) -> str:
    """ "at 10 % risk", or the name of a law."""
    return safe.law or f"at {100.0 * (safe.risk or 0.0):.0f} % risk"


def size_in_words(safe: SafeSize) -> str:
    """A size in mm; a word where there is none, or where each is safe."""
    if safe.value is None:
        return REASONS[safe.reason or NoSize.NO_EQUATION]
    return digits(safe.value * display_of("m").factor)


def shown(probability: Probability) -> str:
    """A probability with its interval: "42 % (27 to 58)"."""
    low, high = (f"{100.0 * end:.0f}" for end in (probability.low, probability.high))
    return f"{percent(probability.value)} % ({low} to {high})"


def answer(shot: ShotAtShield) -> ShieldAnswer:
    """All that equations and shots say about a shot on a shield."""
    ordered = nearest(shot, published().shots, len(published().shots))
    near = [other.shot for other in ordered if other.distance <= NEAR]
    ease, eases = _ease(shot), [_ease(other.shot) for other in ordered]
    easier = [other for other, its in zip(ordered, eases, strict=True) if _is_no_harder(its, ease)]
    harder = [other for other, its in zip(ordered, eases, strict=True) if _is_no_harder(ease, its)]
    return ShieldAnswer(
        probability=probability(shot),
        words=tuple(_words(shot)),
        near=len(near),
        nearest=ordered[:LISTED],
        judged=tuple(judge(law, near, "near") for law in equations()),
        outside=tuple(outside_of_shots(shot)),
        easier=_ordered(easier, [other for other in easier if other.shot.is_perforated]),
        harder=_ordered(harder, [other for other in harder if not other.shot.is_perforated]),
        safe=safe_sizes(shot),
    )


def _ordered(shots: Sequence[NearShot], contrary: Sequence[NearShot]) -> Ordered:
    return Ordered(len(shots), len(contrary), tuple(contrary[:LISTED]))


def _ease(shot: ShotAtShield | ShieldShot) -> tuple[float, ...]:
    """Sizes of a shot that make it easier to hold the larger they are: 1/d, 1/v, 1/cos of the obliquity, its walls."""
    shield = shot.shield
    walls = (shield.bumper_thickness, shield.stand_off, shield.wall_thickness, shield.wall_yield_stress)
    return 1.0 / shot.projectile_diameter, 1.0 / shot.speed, 1.0 / math.cos(shot.obliquity), *walls


def _is_no_harder(one: Sequence[float], other: Sequence[float]) -> bool:
    """Whether a shot is as easy as another one in every respect."""
    return all(its >= EQUAL * own for its, own in zip(one, other, strict=True))


def _words(shot: ShotAtShield) -> Iterator[Word]:
    """What each equation says; one that is about another kind of shield is left out."""
    for law in laws.answering(CRITICAL_DIAMETER):
        if law.meaningless(shot, ""):
            continue
        value = law.evaluate(shot)
        fails = shot.projectile_diameter > value.value
        says: Literal["holds", "fails", "outside"] = "fails" if fails else "holds"
        yield Word(law.name, says if value.in_range else "outside", value.value, laws.in_words(value.reasons))
