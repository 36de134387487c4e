"""What a material is: density, elasticity, equation of state, heat, strength, tension; in SI.

The attribute paths are the paths that a person writes: ``strength.A``. Every number
carries where it comes from and how sure that is; ``None`` where a material goes without (it never
melts, it bears any tension).
"""

import dataclasses
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar

from solver.units import (
    Dimensionless,
    JoulePerKilogram,
    JoulePerKilogramKelvin,
    Kelvin,
    KilogramPerCubicMetre,
    MetrePerSecond,
    Pascal,
    PerKelvin,
    PerPascal,
    PerSecond,
)
from studies.values.nearest import nearest_cure
from studies.values.parameters import Parameter, declared
from studies.values.quantities import refusal, round_quantity

CONFIDENCES: Mapping[str, str] = {
    "read": "read in the cited document",
    "verified": "read in a public report, page or input deck that transcribes the cited source",
    "cross-checked": "recalled, and consistent with independent numbers",
    "computed": "computed from other stated numbers",
    "memory": "recalled and not checked: indicative only",
    "user": "stated by the user",
}


def limits(meaning: str, minimum: float, maximum: float) -> dict[str, Any]:
    """The metadata of a field: its meaning and its inclusive bounds in SI."""
    return {"meaning": meaning, "minimum": minimum, "maximum": maximum}


@dataclass(frozen=True)
class Constant:
    """A number of a material, and where it comes from."""

    value: float | None  # SI; None: the material goes without
    unit: str  # SI symbol
    source: str  # a citation that a reader can check
    confidence: str  # one of CONFIDENCES

    def document(self) -> dict[str, Any]:
        """The number as it stands in a material file."""
        value = "none" if self.value is None else self.value
        return {**dataclasses.asdict(self), "value": value}


@dataclass(frozen=True)
class Elastic:
    """Small-strain stiffness."""

    shear_modulus: Pascal = field(metadata=limits("shear modulus", 1e5, 1e13))
    bulk_modulus: Pascal = field(metadata=limits("bulk modulus", 1e5, 1e13))


@dataclass(frozen=True)
class MieGrueneisen:
    """Equation of state about the Hugoniot Us = c0 + s up, with Gamma rho constant."""

    kind: ClassVar[str] = "mie-grueneisen"
    c0: MetrePerSecond = field(metadata=limits("bulk sound speed", 100.0, 3e4))
    s: Dimensionless = field(metadata=limits("slope of the Hugoniot", 0.0, 10.0))
    gamma0: Dimensionless = field(metadata=limits("Grueneisen parameter", 0.0, 10.0))

    def sound_speed(self, density: float) -> float:
        """Bulk sound speed at rest, m/s."""
        return self.c0


@dataclass(frozen=True)
class Tillotson:
    """Equation of state from compressed solid to vapour."""

    kind: ClassVar[str] = "tillotson"
    a: Dimensionless = field(metadata=limits("Grueneisen parameter of the vapour", 0.01, 10.0))
    b: Dimensionless = field(metadata=limits("what the cold solid has more of it", 0.0, 10.0))
    A: Pascal = field(metadata=limits("bulk modulus", 1e5, 1e13))
    B: Pascal = field(metadata=limits("stiffening with compression", 0.0, 1e13))
    e0: JoulePerKilogram = field(metadata=limits("energy that halves b", 1e3, 1e9))
    e_iv: JoulePerKilogram = field(metadata=limits("incipient vaporisation", 1e3, 1e9))
    e_cv: JoulePerKilogram = field(metadata=limits("complete vaporisation", 1e3, 1e9))
    alpha: Dimensionless = field(metadata=limits("decay of the solid's part", 0.0, 100.0))
    beta: Dimensionless = field(metadata=limits("decay of the cold part", 0.0, 100.0))

    def sound_speed(self, density: float) -> float:
        """Bulk sound speed at rest, m/s."""
        return math.sqrt(self.A / density)


@dataclass(frozen=True)
class Thermal:
    """Heat: temperature follows the internal energy."""

    heat_capacity: JoulePerKilogramKelvin = field(metadata=limits("heat capacity", 1.0, 1e5))
    melt_temperature: Kelvin | None = field(metadata=limits("melting point", 100.0, 1e4))
    room_temperature: Kelvin = field(metadata=limits("initial temperature", 1.0, 5e3))


@dataclass(frozen=True)
class NoYield:
    """Elastic only: no yield surface."""

    kind: ClassVar[str] = "elastic"


@dataclass(frozen=True)
class PerfectlyPlastic:
    """A constant yield stress."""

    kind: ClassVar[str] = "perfectly-plastic"
    yield_stress: Pascal = field(metadata=limits("yield stress", 0.0, 1e12))


@dataclass(frozen=True)
class LinearHardening:
    """A yield stress that grows in proportion to plastic strain."""

    kind: ClassVar[str] = "linear-hardening"
    yield_stress: Pascal = field(metadata=limits("initial yield stress", 0.0, 1e12))
    hardening_modulus: Pascal = field(metadata=limits("hardening modulus", 0.0, 1e13))


@dataclass(frozen=True)
class JohnsonCook:
    """(A + B eps^n) (1 + C ln(rate / reference_rate)) (1 - T*^m); no softening without m."""

    kind: ClassVar[str] = "johnson-cook"
    A: Pascal = field(metadata=limits("initial yield stress", 0.0, 1e12))
    B: Pascal = field(metadata=limits("hardening", 0.0, 1e12))
    n: Dimensionless = field(metadata=limits("hardening exponent", 0.0, 10.0))
    C: Dimensionless = field(metadata=limits("rate sensitivity", 0.0, 10.0))
    m: Dimensionless | None = field(metadata=limits("softening exponent", 0.01, 100.0))
    reference_rate: PerSecond = field(metadata=limits("reference strain rate", 1e-9, 1e9))


@dataclass(frozen=True)
class SteinbergGuinan:
    """min(Y0 (1 + beta eps)^n, Y_max) G / G0; G and the melting point follow the state.

    The melting point of the material is that at its density at rest.
    """

    kind: ClassVar[str] = "steinberg-guinan"
    Y0: Pascal = field(metadata=limits("initial yield stress", 0.0, 1e12))
    Y_max: Pascal = field(metadata=limits("hardest yield stress", 0.0, 1e12))
    beta: Dimensionless = field(metadata=limits("hardening", 0.0, 1e5))
    n: Dimensionless = field(metadata=limits("hardening exponent", 0.0, 10.0))
    A: PerPascal = field(metadata=limits("rise of the shear modulus with pressure", 0.0, 1e-9))
    B: PerKelvin = field(metadata=limits("fall of the shear modulus with temperature", 0.0, 0.1))
    a: Dimensionless = field(metadata=limits("rise of the melting point with density", 0.0, 10.0))
    gamma0: Dimensionless = field(metadata=limits("Grueneisen parameter", 0.0, 10.0))


@dataclass(frozen=True)
class Tension:
    """What the material bears in hydrostatic tension."""

    spall_strength: Pascal | None = field(metadata=limits("spall strength", 0.0, 1e12))


Eos = MieGrueneisen | Tillotson
Strength = NoYield | PerfectlyPlastic | LinearHardening | JohnsonCook | SteinbergGuinan

EQUATIONS_OF_STATE: Mapping[str, type] = {kind.kind: kind for kind in (MieGrueneisen, Tillotson)}
STRENGTHS: Mapping[str, type] = {
    kind.kind: kind
    for kind in (NoYield, PerfectlyPlastic, LinearHardening, JohnsonCook, SteinbergGuinan)
}
# The sections of a material: the record of each, or the records by kind.
SECTIONS: Mapping[str, type | Mapping[str, type]] = {
    "elastic": Elastic,
    "eos": EQUATIONS_OF_STATE,
    "thermal": Thermal,
    "strength": STRENGTHS,
    "tension": Tension,
}


@dataclass(frozen=True)
class YieldStress:
    """A published yield stress: what a law that asks for one is evaluated with."""

    label: str  # short, unique within the material: "Y = 240 MPa"
    value: Pascal = field(metadata=limits("yield stress", 1e3, 1e12))


@dataclass(frozen=True)
class Scalars:
    """The numbers of a material that belong to no section."""

    density: KilogramPerCubicMetre = field(metadata=limits("density", 1.0, 3e4))
    brinell_hardness: Dimensionless | None = field(
        default=None, metadata=limits("Brinell hardness number", 0.1, 2e3)
    )


@dataclass(frozen=True, kw_only=True)
class Material:
    """A material: constants in SI, yield stresses for laws, and the source of each number."""

    name: str
    title: str
    family: str  # what laws mean by "same material": "copper", "aluminium"
    density: KilogramPerCubicMetre
    elastic: Elastic
    eos: Eos
    thermal: Thermal
    strength: Strength
    tension: Tension
    yield_stresses: tuple[YieldStress, ...] = ()
    brinell_hardness: Dimensionless | None = None
    sources: Mapping[str, Constant] = field(default_factory=dict, compare=False, repr=False)

    @property
    def sound_speed(self) -> float:
        """Bulk sound speed at rest, m/s: what laws mean by it."""
        return self.eos.sound_speed(self.density)

    def parameters(self) -> dict[str, Parameter]:
        """Every constant that can be set, by dotted path."""
        return {path: one for path, one in self._parameters() if path not in NOT_SET}

    def paths(self) -> dict[str, str]:
        """The SI unit of every constant that can be set, by dotted path."""
        return {path: parameter.unit or "1" for path, parameter in self.parameters().items()}

    def value_at(self, path: str) -> float | None:
        """The constant at a dotted path; raises InvalidInput with the nearest path."""
        self._check(path)
        section, _, name = path.rpartition(".")
        return getattr(getattr(self, section) if section else self, name)

    def with_value(
        self, path: str, value: float | None, *, source: str = "set in the sweep"
    ) -> "Material":
        """The material with one constant changed (SI); raises InvalidInput with the nearest."""
        self._check(path)
        number = None if value is None else round_quantity(value)
        quantity = Constant(number, self.paths()[path], source, "user")
        section, _, name = path.rpartition(".")
        part = dataclasses.replace(getattr(self, section), **{name: number}) if section else number
        change: dict[str, Any] = {
            section or name: part,
            "sources": {**self.sources, path: quantity},
        }
        return dataclasses.replace(self, **change)

    def resolved(self) -> dict[str, Any]:
        """The material as plain nested values: what a run stores. Sources stay behind."""
        plain = {f.name: getattr(self, f.name) for f in dataclasses.fields(self)}
        del plain["sources"]
        for section in SECTIONS:
            plain[section] = _with_kind(plain[section])
        return plain | {"yield_stresses": [dict(vars(y)) for y in self.yield_stresses]}

    @staticmethod
    def from_resolved(plain: Mapping[str, Any]) -> "Material":
        """The material that ``resolved()`` wrote down, without sources."""
        parts = {section: _record(section, plain[section]) for section in SECTIONS}
        yields = tuple(YieldStress(**one) for one in plain["yield_stresses"])
        return Material(**{**plain, **parts, "yield_stresses": yields})

    def document(self) -> dict[str, Any]:
        """The material in the schema of a material file, in SI: it loads as itself."""
        document: dict[str, Any] = {"name": self.name, "title": self.title, "family": self.family}
        for section in SECTIONS:
            kind = getattr(getattr(self, section), "kind", None)
            document[section] = {"kind": kind} if kind else {}
        for path, quantity in self.sources.items():
            section, _, name = path.rpartition(".")
            if not path.startswith("yield_stresses."):  # whose labels may hold a point
                (document[section] if section else document)[name] = quantity.document()
        document["yield_stresses"] = [
            {"label": y.label, **self.sources[f"yield_stresses.{y.label}"].document()}
            for y in self.yield_stresses
        ]
        return document

    def _check(self, path: str) -> None:
        if path not in self.parameters():
            limit = f"a constant of {self.name} ({self.strength.kind})"
            raise refusal(path, path, limit, nearest_cure(path, self.parameters()))

    def _parameters(self) -> Iterator[tuple[str, Parameter]]:
        yield from declared(Scalars).items()
        for section in SECTIONS:
            for name, parameter in declared(type(getattr(self, section))).items():
                yield f"{section}.{name}", parameter


# What laws, reports and checks read and no simulation does: runs that differ in these alone are the same. The bulk
# modulus that acts is that of the equation of state; the stated one is there to be compared with it.
NOT_SIMULATED = ("name", "title", "family", "yield_stresses", "brinell_hardness")
NOT_SET = ("elastic.bulk_modulus",)


def simulated(resolved: Mapping[str, Any]) -> dict[str, Any]:
    """The part of a resolved material that decides the outcome of a simulation."""
    kept = {key: value for key, value in resolved.items() if key not in NOT_SIMULATED}
    for path in NOT_SET:
        section, _, name = path.partition(".")
        kept[section] = {key: value for key, value in kept[section].items() if key != name}
    return kept


def record_of(section: str, kind: object, path: str) -> type:
    """The record of a section, chosen by its kind where it has kinds; raises InvalidInput."""
    records = SECTIONS[section]
    if isinstance(records, type):
        return records
    if not isinstance(kind, str) or kind not in records:
        limit = "one of " + ", ".join(records)
        raise refusal(f"{path}.kind", kind, limit, nearest_cure(kind, records))
    return records[kind]


def _with_kind(record: Any) -> dict[str, Any]:
    kind = {"kind": record.kind} if hasattr(record, "kind") else {}
    return kind | vars(record)


def _record(section: str, plain: Mapping[str, Any]) -> Any:
    values = {name: value for name, value in plain.items() if name != "kind"}
    return record_of(section, plain.get("kind"), section)(**values)
