"""A law that was fitted to a sweep or to shots, as a document that the next sweep brings along.

``studies.fits`` writes the document; a sweep has it under ``laws``. It states form, constants with intervals, the range
of the fitted points and their source, so that nothing else is needed to evaluate it.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TypeGuard

from studies.fits.forms import FORMS, Form, columns_of, dimension_of
from studies.laws import Code, Law, Limit, Range, Reason, Shot
from studies.laws import names as shipped
from studies.laws._range import length_ratio, speed, thickness_ratio
from studies.quantities.findings import Finding, Findings, InvalidInput, nearest_cure, refusal, shown
from studies.quantities.parameters import Plain
from studies.quantities.units import is_number, parse_quantity, readable

KEYS = ("law", "title", "quantity", "form", "equation", "constants", "level", "points", "scatter", "range", "source")
RANGE_KEYS = ("speed", "thickness_ratio", "length_ratio", "materials")
LONGEST = 500  # characters of a text
EXAMPLE = "write it with `whipple fit CUBE --form power --out FILE`"


@dataclass(frozen=True)
class FittedConstant:
    """A constant with its interval."""

    value: float
    low: float
    high: float


@dataclass(frozen=True)
class FittedRange:
    """The range of the fitted points."""

    speed: tuple[float, float]  # m/s
    thickness_ratio: tuple[float, float] | None  # None without a plate
    length_ratio: tuple[float, float]
    materials: tuple[str, str]  # projectile, target


@dataclass(frozen=True)
class FittedLaw:
    """A law whose constants were fitted."""

    name: str
    title: str  # "fit of craters"
    quantity: str
    form: Form
    constants: Mapping[str, FittedConstant]
    level: float  # confidence of the intervals: 0.95
    points: int  # fitted
    scatter: float  # of the points about the law, relative standard deviation
    range: FittedRange
    source: str

    def document(self) -> dict[str, Plain]:
        """The law as plain values that ``read_law`` reads as itself."""
        limits: dict[str, Plain] = {"speed": [readable(end, "m s-1") for end in self.range.speed]}
        if self.range.thickness_ratio is not None:
            limits["thickness_ratio"] = list(self.range.thickness_ratio)
        return {
            "law": self.name,
            "title": self.title,
            "quantity": self.quantity,
            "form": self.form.name,
            "equation": self.form.equation_for(self.quantity),
            "constants": {
                name: {"value": constant.value, "low": constant.low, "high": constant.high}
                for name, constant in self.constants.items()
            },
            "level": self.level,
            "points": self.points,
            "scatter": self.scatter,
            "range": {**limits, "length_ratio": list(self.range.length_ratio), "materials": list(self.range.materials)},
            "source": self.source,
        }

    def as_law(self) -> Law:
        """The law as every other one, for cube and report."""
        constants = [constant.value for constant in self.constants.values()]
        stated = ", ".join(
            f"{name} = {constant.value:.4g} ({constant.low:.4g} to {constant.high:.4g})"
            for name, constant in self.constants.items()
        )

        def ratio(shot: Shot, variant: str) -> float:
            return float(self.form.ratio(columns_of([shot]), constants)[0])

        def meaningless(shot: Shot, variant: str) -> Reason | None:
            value = ratio(shot, variant)
            return None if math.isfinite(value) and value > 0.0 else Reason(Code.NO_VALUE)

        return Law(
            name=self.name,
            title=self.title,
            quantity=self.quantity,
            equation=f"{self.form.equation_for(self.quantity)}: {stated}, {self.level:.0%} intervals",
            source=f"{self.title}: {self.points} points of {self.source}",
            confidence="computed",
            range=self._range(),
            scatter=self.scatter,
            dimension=dimension_of(self.quantity),
            size_exponent=float(dimension_of(self.quantity)),
            ratio=ratio,
            meaningless=meaningless,
        )

    def _range(self) -> Range:
        low, high = self.range.speed
        limits = [speed(low / 1e3, high / 1e3, self.title), _materials(self)]
        if self.range.thickness_ratio is not None:
            limits.append(thickness_ratio(*self.range.thickness_ratio, self.title))
        return Range(*limits, projectile=length_ratio(*self.range.length_ratio, self.title))


def _materials(law: FittedLaw) -> Limit:
    def check(limit: Limit, shot: Shot) -> Reason | None:
        mine = (shot.projectile.name, shot.target.name)
        return None if mine == limit.names else limit.broken(found={"projectile": mine[0], "target": mine[1]})

    return Limit(Code.MATERIALS, law.title, names=law.range.materials, check=check)


# ---- from a document -----------------------------------------------------------------------------


def read_law(document: object, path: str) -> FittedLaw:
    """The law of a document; raises InvalidInput with every finding, each below ``path``."""
    if not isinstance(document, Mapping):
        raise refusal(path, document, "the content of the file of a fit", EXAMPLE)
    return _Reading(document, path).law()


class _Reading:
    """One document being read, with the findings so far."""

    def __init__(self, document: Mapping[str, object], path: str):
        self.document, self.path, self.findings = document, path, Findings()

    def law(self) -> FittedLaw:
        for key in self.document:
            if key not in KEYS:
                self._refuse(key, key, "a key of a fit", nearest_cure(key, KEYS))
        form = FORMS.get(str(self.document.get("form")))
        if form is None:
            name = self.document.get("form")
            self._refuse("form", name, "a form of law", nearest_cure(name, FORMS))
            raise InvalidInput(self.findings)
        name, quantity = self._text("law"), self._text("quantity")
        if name in shipped():
            self._refuse("law", name, "a name that no published law has", f"call it my-{name}")
        if quantity not in form.quantities:
            cure = nearest_cure(quantity, form.quantities)
            self._refuse("quantity", quantity, f"a quantity of the form {form.name}", cure)
        points = self._number("points", self.document.get("points"), 1.0, 1e9)
        law = FittedLaw(
            name=name,
            title=self._text("title"),
            quantity=quantity,
            form=form,
            constants=self._constants(form),
            level=self._number("level", self.document.get("level"), 0.0, 1.0),
            points=0 if math.isnan(points) else int(points),
            scatter=self._number("scatter", self.document.get("scatter"), 0.0, math.inf),
            range=self._range(),
            source=self._text("source"),
        )
        if self.findings:
            raise InvalidInput(self.findings)
        return law

    def _refuse(self, key: str, value: object, limit: str, cure: str) -> None:
        self.findings.append(Finding(f"{self.path}.{key}", shown(value), limit, cure))

    def _text(self, key: str) -> str:
        text = self.document.get(key)
        if isinstance(text, str) and 0 < len(text.strip()) <= LONGEST:
            return text.strip()
        self._refuse(key, text, f"a text of at most {LONGEST} characters", EXAMPLE)
        return ""

    def _number(self, key: str, raw: object, low: float, high: float) -> float:
        if isinstance(raw, int | float) and is_number(raw) and low <= raw <= high and math.isfinite(raw):
            return float(raw)
        self._refuse(key, raw, f"a number from {low:g} to {high:g}", EXAMPLE)
        return math.nan

    def _constants(self, form: Form) -> dict[str, FittedConstant]:
        stated = self.document.get("constants")
        if not isinstance(stated, Mapping) or set(stated) != set(form.constants):
            limit = f"the constants {', '.join(form.constants)}"
            self._refuse("constants", stated, limit, EXAMPLE)
            return {}
        read = {}
        for name in form.constants:
            part = stated[name] if isinstance(stated[name], Mapping) else {}
            numbers = [
                self._number(f"constants.{name}.{key}", part.get(key), -math.inf, math.inf)
                for key in ("value", "low", "high")
            ]
            read[name] = FittedConstant(*numbers)
        return read

    def _range(self) -> FittedRange:
        stated = self.document.get("range")
        if not isinstance(stated, Mapping) or not set(stated) <= set(RANGE_KEYS):
            self._refuse("range", stated, f"a mapping with {', '.join(RANGE_KEYS)}", EXAMPLE)
            stated = {}
        materials = stated.get("materials")
        if not _is_pair(materials) or not all(isinstance(name, str) for name in materials):
            self._refuse("range.materials", materials, "[projectile, target]", EXAMPLE)
            materials = ("", "")
        thickness = stated.get("thickness_ratio")
        return FittedRange(
            speed=self._pair("range.speed", stated.get("speed"), "m s-1"),
            thickness_ratio=None if thickness is None else self._pair("range.thickness_ratio", thickness, "1"),
            length_ratio=self._pair("range.length_ratio", stated.get("length_ratio"), "1"),
            materials=(str(materials[0]), str(materials[1])),
        )

    def _pair(self, key: str, raw: object, unit: str) -> tuple[float, float]:
        """Two numbers in SI, the smaller first."""
        if not _is_pair(raw):
            self._refuse(key, raw, "[smallest, largest]", EXAMPLE)
            return (math.nan, math.nan)
        try:
            low, high = (float(parse_quantity(end, unit, f"{self.path}.{key}")) for end in raw)
        except InvalidInput as error:
            self.findings.extend(error.findings)
            return (math.nan, math.nan)
        if not low <= high:
            self._refuse(key, raw, "[smallest, largest]", "exchange the two")
        return (low, high)


def _is_pair(raw: object) -> TypeGuard[Sequence[object]]:
    return isinstance(raw, Sequence) and not isinstance(raw, str) and len(raw) == 2
