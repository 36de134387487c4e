"""A law that was fitted to a sweep or to shots, as a document that the next sweep brings along.

``studies.fits`` writes the document; a sweep has it under ``laws``. It states form, constants with intervals, the range
of the fitted points and their source, so that nothing else is needed to evaluate it.
"""

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any

from pydantic import BaseModel, Field, StringConstraints, ValidationError
from pydantic_core import ErrorDetails

from studies.fits.forms import FORMS, Form, columns_of, dimension_of
from studies.laws import Code, Law, Limit, Range, Reason, Shot
from studies.laws import names as shipped
from studies.laws._range import length_ratio, speed, thickness_ratio
from studies.quantities.findings import Finding, Findings, InvalidInput, nearest_cure, refusal, shown
from studies.quantities.parameters import Plain
from studies.quantities.units import parse_quantity, readable

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

Text = Annotated[str, StringConstraints(strip_whitespace=True, min_length=1, max_length=500)]
Ends = Annotated[list[float | str], Field(min_length=2, max_length=2)]  # with a unit where there is one


class _Part(BaseModel, extra="forbid", strict=True, allow_inf_nan=False):
    """A part of a document, which has no key besides its own."""


class _Constant(_Part):
    value: float
    low: float
    high: float


class _Range(_Part):
    speed: Ends
    thickness_ratio: Ends | None = None
    length_ratio: Ends
    materials: Annotated[list[str], Field(min_length=2, max_length=2)]


class _Document(_Part):
    """A law as ``FittedLaw.document`` writes it; the equation is that of its form."""

    law: Text
    title: Text
    quantity: Text
    form: str
    equation: str = ""
    constants: dict[str, _Constant]
    level: Annotated[float, Field(ge=0.0, le=1.0)]
    points: Annotated[int, Field(ge=1)]
    scatter: Annotated[float, Field(ge=0.0)]
    range: _Range
    source: Text


def read_law(document: object, path: str) -> FittedLaw:
    """The law of a document; raises InvalidInput with every finding, each below ``path``."""
    if not isinstance(document, Mapping):
        raise refusal(path, document, "the content of the file of a fit", EXAMPLE)
    try:
        read = _Document.model_validate_json(json.dumps(document, default=str))
    except ValidationError as error:
        raise InvalidInput([_finding(each, path) for each in error.errors()]) from None
    form, findings = FORMS.get(read.form), Findings()
    if form is None:
        raise refusal(f"{path}.form", read.form, "a form of law", nearest_cure(read.form, FORMS))
    if read.law in shipped():
        limit = "a name that no published law has"
        findings.append(Finding(f"{path}.law", read.law, limit, f"call it my-{read.law}"))
    if read.quantity not in form.quantities:
        cure = nearest_cure(read.quantity, form.quantities)
        findings.append(Finding(f"{path}.quantity", read.quantity, f"a quantity of the form {form.name}", cure))
    if {*read.constants} != {*form.constants}:
        limit = f"the constants {', '.join(form.constants)}"
        findings.append(Finding(f"{path}.constants", shown(", ".join(read.constants)), limit, EXAMPLE))
    ends: dict[str, Any] = {}
    for name, unit in (("speed", "m s-1"), ("thickness_ratio", "1"), ("length_ratio", "1")):
        stated = getattr(read.range, name)
        ends[name] = stated and findings.attempt(_ends, stated, unit, f"{path}.range.{name}")
    findings.check()
    return FittedLaw(
        name=read.law,
        title=read.title,
        quantity=read.quantity,
        form=form,
        constants={name: FittedConstant(**read.constants[name].model_dump()) for name in form.constants},
        level=read.level,
        points=read.points,
        scatter=read.scatter,
        range=FittedRange(**ends, materials=(read.range.materials[0], read.range.materials[1])),
        source=read.source,
    )


def _finding(error: ErrorDetails, path: str) -> Finding:
    field = ".".join([path, *map(str, error["loc"])])
    if error["type"] == "extra_forbidden":
        key = str(error["loc"][-1])
        return Finding(field, key, "a key of a fit", nearest_cure(key, _Document.model_fields))
    if error["type"] == "missing":
        return Finding(field, "nothing", "a value", EXAMPLE)
    return Finding(field, shown(error["input"]), error["msg"], EXAMPLE)


def _ends(stated: Sequence[float | str], unit: str, field: str) -> tuple[float, float]:
    """Two numbers in SI, the smaller first; raises InvalidInput."""
    low, high = (float(parse_quantity(end, unit, field)) for end in stated)
    if not low <= high:
        raise refusal(field, stated, "[smallest, largest]", "exchange the two")
    return low, high
