"""The schema of a material: density, elasticity, equation of state, heat, strength, tension; in SI.

A person writes a constant as a dotted path: ``strength.A``. The constants of an equation of state and of a strength
are declared in the file of that model, in ``solver/matter/eos/`` and ``solver/matter/strength/``. Every number carries
its source and how sure that is; ``None`` where a material goes without (it never melts, it bears any tension).
"""

import dataclasses
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache, cached_property
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated

from solver.registry import entries
from solver.units import (
    Below,
    Described,
    Dimensionless,
    FromMaterial,
    JoulePerKilogram,
    JoulePerKilogramKelvin,
    Kelvin,
    KilogramPerCubicMetre,
    Pascal,
    PerSecond,
    Unit,
    marked,
)
from studies.quantities.findings import nearest_cure, refusal
from studies.quantities.parameters import Parameter, Plain, Value, declared
from studies.quantities.units import round_quantity

if TYPE_CHECKING:
    from solver.matter.eos import EosEntry
    from solver.matter.strength import StrengthEntry

CONFIDENCES: Mapping[str, str] = {
    "read": "read in the cited document",
    "verified": "read in a public report, page or input deck that transcribes the cited source",
    "second-hand": "quoted from the cited document by another one, which does not state everything",
    "cross-checked": "quoted from memory, and consistent with independent numbers",
    "computed": "computed from other stated numbers",
    "indicative": "a rule of thumb, a limit or a stand-in, whatever its source: indicative only",
    "memory": "quoted from memory and unchecked: indicative only",
    "user": "stated by the user",
}


@dataclass(frozen=True)
class Constant:
    """A number of a material, and where it comes from."""

    value: float | None  # SI; None: the material goes without
    unit: str  # SI symbol
    source: str  # a citation that a reader can check
    confidence: str  # one of CONFIDENCES

    def document(self) -> dict[str, Value]:
        """The number as it stands in a material file."""
        value = "none" if self.value is None else self.value
        return {**dataclasses.asdict(self), "value": value}


@dataclass(frozen=True)
class Stiffness:
    """Small-strain stiffness."""

    shear_modulus: Annotated[Pascal, Described("shear modulus", 1e5, 1e13, usual=(1e8, 6e11))]
    bulk_modulus: Annotated[Pascal, Described("bulk modulus", 1e5, 1e13, usual=(1e9, 6e11))]


@dataclass(frozen=True)
class Thermal:
    """Heat: temperature follows the internal energy."""

    heat_capacity: Annotated[JoulePerKilogramKelvin, Described("heat capacity", 1.0, 1e5, usual=(100.0, 2500.0))]
    melt_temperature: Annotated[Kelvin | None, Described("melting point", 100.0, 1e4, usual=(200.0, 4500.0))]
    room_temperature: Annotated[
        Kelvin, Described("initial temperature", 1.0, 5e3, usual=(4.0, 2000.0)), Below("melt_temperature")
    ]
    # At 1 bar; the melting point above is that of the strength where it has one of its own.
    solidus: Annotated[
        Kelvin | None,
        Described("temperature at which melting begins", 100.0, 1e4, usual=(200.0, 4500.0)),
        Below("liquidus", or_equal=True),
    ] = None
    liquidus: Annotated[
        Kelvin | None, Described("temperature at which melting ends", 100.0, 1e4, usual=(200.0, 4500.0))
    ] = None
    heat_to_solidus: Annotated[
        JoulePerKilogram | None,
        Described("heat from the initial temperature to the solidus", 1e3, 1e8, usual=(1e4, 2e6)),
    ] = None
    incipient_vaporisation: Annotated[
        JoulePerKilogram | None, Described("energy with which vaporisation begins", 1e4, 1e9, usual=(1e5, 2e7))
    ] = None
    latent_heat_of_fusion: Annotated[
        JoulePerKilogram | None, Described("latent heat of fusion", 1e3, 1e7, usual=(1e4, 2e6))
    ] = None
    # Without it the melting point is the same at every density.
    melting_slope: Annotated[
        Dimensionless | None,
        Described("rise of the melting point with density, a of Lindemann's rule", 0.01, 10.0, usual=(0.5, 4.0)),
    ] = None
    melting_density: Annotated[
        Dimensionless | None,
        Described(
            "density of the melting point over that at rest; by default that of matter melting at 1 bar",
            0.5,
            2.0,
            usual=(0.7, 1.3),
        ),
    ] = None


@dataclass(frozen=True)
class Tension:
    """Tension that the material bears: as a whole, at the tip of a crack, and as a liquid."""

    spall_strength: Annotated[Pascal | None, Described("spall strength", 0.0, 1e12, usual=(1e6, 2e10))]
    fracture_toughness: Annotated[
        float | None,
        Unit("Pa m0.5"),
        Described("fracture toughness, for the size of fragments", 1e4, 1e9, usual=(1e5, 4e8)),
    ] = None
    surface_tension: Annotated[
        float | None,
        Unit("N m-1"),
        Described("surface tension of the liquid, for the size of its drops", 1e-3, 10.0, usual=(0.01, 3.0)),
    ] = None


@dataclass(frozen=True)
class FractureStrain:
    """Johnson and Cook's fracture strain and damage (``matter/failure/johnson_cook.py``): all numbers, or none."""

    D1: Annotated[Dimensionless | None, Described("fracture strain D1", -10.0, 10.0, usual=(-3.0, 3.0))] = None
    D2: Annotated[Dimensionless | None, Described("fracture strain D2", -100.0, 100.0, usual=(0.0, 20.0))] = None
    D3: Annotated[Dimensionless | None, Described("fracture strain D3", -100.0, 100.0, usual=(-10.0, 0.0))] = None
    D4: Annotated[Dimensionless | None, Described("fracture strain D4", -1.0, 1.0, usual=(-0.05, 0.1))] = None
    D5: Annotated[Dimensionless | None, Described("fracture strain D5", -100.0, 100.0, usual=(-1.0, 10.0))] = None
    reference_rate: Annotated[
        PerSecond | None, Described("reference strain rate of the fracture strain", 1e-9, 1e9, usual=(1e-6, 1e5))
    ] = None
    critical_damage: Annotated[
        Dimensionless | None, Described("damage at which matter fails", 0.0, 1.0, usual=(0.05, 1.0))
    ] = None
    threshold: Annotated[
        Dimensionless | None, Described("plastic strain from which on damage grows", 0.0, 10.0, usual=(0.0, 0.5))
    ] = None


@dataclass(frozen=True)
class SpallStrength:
    """Spall strength at a strain rate, its power, and voids (``matter/failure/void_growth.py``): all, or none."""

    strength: Annotated[
        Pascal | None, Described("spall strength at the strain rate of its source", 1e3, 1e12, usual=(1e7, 2e10))
    ] = None
    strain_rate: Annotated[
        PerSecond | None, Described("strain rate of the spall strength", 1.0, 1e12, usual=(1e2, 1e9))
    ] = None
    exponent: Annotated[
        Dimensionless | None, Described("power of the strain rate in the spall strength", 0.01, 1.0, usual=(0.05, 0.6))
    ] = None
    dilute_voids: Annotated[
        Dimensionless | None,
        Described("void fraction up to which voids grow as if alone", 1e-9, 0.1, usual=(1e-6, 0.05)),
    ] = None
    coalescence: Annotated[
        Dimensionless | None, Described("void fraction at which voids link", 1e-3, 0.9, usual=(0.01, 0.7))
    ] = None


@dataclass(frozen=True)
class Model:
    """A model that the material chooses by its kind, with the constants that its file gives."""

    kind: str  # name of an equation of state or of a strength
    constants: Mapping[str, float | None]  # by the described fields of the model's record; SI


# The sections of a material: the record of each, or the folder whose models it chooses from.
SECTIONS: Mapping[str, type | tuple[str, str]] = {
    "elastic": Stiffness,
    "eos": ("solver.matter.eos", "EOS"),
    "thermal": Thermal,
    "strength": ("solver.matter.strength", "STRENGTH"),
    "tension": Tension,
    "fracture": FractureStrain,
    "spall": SpallStrength,
}
# Sections that a material may go without.
OPTIONAL = ("fracture", "spall")


@cache
def models(section: str) -> "Mapping[str, EosEntry | StrengthEntry]":
    """The models that a section can choose, by kind: those whose record a material can fill."""
    folder = SECTIONS[section]
    assert isinstance(folder, tuple)
    return MappingProxyType(
        {
            name: entry
            for name, entry in entries(*folder).items()
            if not getattr(entry, "kind", "")
            and set(entry.record._fields)
            <= {*declared(entry.record), *marked(entry.record, FromMaterial), *entry.record._field_defaults}
        }
    )


def record_of(section: str, kind: object, path: str) -> type:
    """The record of a section, chosen by its kind where it has kinds; raises InvalidInput."""
    record = SECTIONS[section]
    if isinstance(record, type):
        return record
    kinds = models(section)
    if not isinstance(kind, str) or kind not in kinds:
        limit = "one of " + ", ".join(kinds)
        raise refusal(f"{path}.kind", kind, limit, nearest_cure(kind, kinds))
    return kinds[kind].record


Section = Stiffness | Thermal | Tension | FractureStrain | SpallStrength | Model


def section_of(section: str, constants: Mapping[str, Value]) -> Section:
    """A section of a material from its constants, the kind among them where it has kinds."""
    record = SECTIONS[section]
    if isinstance(record, type):
        made: Section = record(**constants)
        return made
    numbers = {name: value for name, value in constants.items() if not isinstance(value, str)}
    return Model(str(constants["kind"]), numbers)


@dataclass(frozen=True)
class YieldStress:
    """A published yield stress, with which laws are evaluated."""

    label: str  # short, unique within the material: "Y = 240 MPa"
    value: Annotated[Pascal, Described("yield stress", 1e3, 1e12, usual=(1e6, 5e9))]


@dataclass(frozen=True)
class Scalars:
    """The numbers of a material that belong to no section."""

    density: Annotated[KilogramPerCubicMetre, Described("density", 1.0, 3e4, usual=(500.0, 23e3))]
    brinell_hardness: Annotated[
        Dimensionless | None, Described("Brinell hardness number", 0.1, 2e3, usual=(1.0, 1000.0))
    ] = None


TEXTS = ("name", "title", "family", "alloy")


@dataclass(frozen=True, kw_only=True)
class Material:
    """A material: constants in SI, yield stresses for laws, and the source of each number."""

    name: str
    title: str
    family: str  # what laws mean by "same material": "copper", "aluminium"
    alloy: str = ""  # shared by its tempers and by other sources of its constants: "6061"
    density: KilogramPerCubicMetre
    elastic: Stiffness
    eos: Model
    thermal: Thermal
    strength: Model
    tension: Tension
    fracture: FractureStrain = FractureStrain()
    spall: SpallStrength = SpallStrength()
    yield_stresses: tuple[YieldStress, ...] = ()
    brinell_hardness: Dimensionless | None = None
    sources: Mapping[str, Constant] = field(default_factory=dict, compare=False, repr=False)

    @property
    def sound_speed(self) -> float:
        """Bulk sound speed at rest, m/s, for laws."""
        from solver.matter.eos import reference_sound_speed

        return reference_sound_speed(models("eos")[self.eos.kind].record(**self.fill("eos")))

    @property
    def stiffness(self) -> float:
        """Bulk modulus of the equation of state at rest, Pa, which the stated one agrees with."""
        return self.density * self.sound_speed**2

    def fill(self, section: str, record: type | None = None) -> dict[str, float | None]:
        """The fields without default of a section's model, or of another record that takes the same constants."""
        model: Model = getattr(self, section)
        own = models(section)[model.kind].record
        constants = model.constants if declared(record or own) else {}
        return {**self.taken(record or own), **constants}

    def taken(self, record: type) -> dict[str, float | None]:
        """The fields of a model's record that are ``FromMaterial``."""
        return {name: self.constant(mark.path) for name, mark in marked(record, FromMaterial).items()}

    @cached_property
    def parameters(self) -> Mapping[str, Parameter]:
        """Every constant that can be set, by dotted path."""
        parameters = dict(declared(Scalars))
        for section in SECTIONS:
            for name, parameter in declared(self._record(section)).items():
                parameters[f"{section}.{name}"] = parameter
        taken = {mark.path for mark in marked(acting_eos(self.eos.kind).record, FromMaterial).values()}
        if STIFFNESS not in taken:
            del parameters[STIFFNESS]
        return parameters

    def paths(self) -> dict[str, str]:
        """The SI unit of every constant that can be set, by dotted path."""
        return {path: parameter.unit or "1" for path, parameter in self.parameters.items()}

    def value_at(self, path: str) -> float | None:
        """The constant at a dotted path; raises InvalidInput with the nearest path."""
        if path not in self.parameters:
            limit = f"a constant of {self.name} ({self.strength.kind})"
            raise refusal(path, path, limit, nearest_cure(path, self.parameters))
        return self.constant(path)

    def constant(self, path: str) -> float | None:
        """The constant at a dotted path of the schema, also one that nothing of this material takes."""
        section, _, name = path.rpartition(".")
        value: float | None = self._constants(section)[name] if section else getattr(self, name)
        return value

    def with_value(self, path: str, value: float | None, *, source: str = "set in the sweep") -> "Material":
        """The material with one constant changed (SI); raises InvalidInput with the nearest."""
        self.value_at(path)
        number = None if value is None else round_quantity(value)
        sources = {**self.sources, path: Constant(number, self.paths()[path], source, "user")}
        section, _, name = path.rpartition(".")
        if not section:
            return dataclasses.replace(self, **{name: number}, sources=sources)  # type: ignore[arg-type]
        part = section_of(section, {**self._plain(section), name: number})
        return dataclasses.replace(self, **{section: part}, sources=sources)  # type: ignore[arg-type]

    def below(self) -> Iterator[tuple[str, str, bool]]:
        """Paths of constants that make sense in one order: the lower, the higher, and whether they may be equal."""
        for section in SECTIONS:
            for name, mark in marked(self._record(section), Below).items():
                yield f"{section}.{name}", f"{section}.{mark.field}", mark.or_equal

    def usual(self) -> Iterator[tuple[str, Described]]:
        """Paths of constants of which a usual range is known, and what is known of each."""
        records = {"": Scalars, **{f"{section}.": self._record(section) for section in SECTIONS}}
        for section, record in records.items():
            for name, about in marked(record, Described).items():
                if about.usual is not None:
                    yield section + name, about

    def resolved(self) -> dict[str, Plain]:
        """The material as plain nested values, as a run stores it. Sources stay behind."""
        plain: dict[str, Plain] = {f.name: getattr(self, f.name) for f in dataclasses.fields(self) if f.compare}
        plain |= {section: self._plain(section) for section in SECTIONS}
        for section in OPTIONAL:
            if not any(value is not None for value in self._constants(section).values()):
                del plain[section]
        return plain | {"yield_stresses": [dict(vars(y)) for y in self.yield_stresses]}

    @staticmethod
    def from_resolved(plain: Mapping[str, Plain]) -> "Material":
        """The material that ``resolved()`` wrote down, without sources."""
        parts = {section: section_of(section, plain.get(section, {})) for section in SECTIONS}  # type: ignore[arg-type]
        yields = tuple(YieldStress(**stress) for stress in plain["yield_stresses"])  # type: ignore[union-attr,arg-type]
        return Material(**{**plain, **parts, "yield_stresses": yields})  # type: ignore[arg-type]

    def document(self) -> dict[str, Plain]:
        """The material in the schema of a material file, in SI: it loads as itself."""
        document: dict[str, Plain] = {text: getattr(self, text) for text in TEXTS}
        sections: dict[str, dict[str, Plain]] = {section: {**self._choice(section)} for section in SECTIONS}
        for path, quantity in self.sources.items():
            section, _, name = path.rpartition(".")
            if not path.startswith("yield_stresses."):  # whose labels may hold a point
                (sections[section] if section else document)[name] = quantity.document()
        labels = [stress.label for stress in self.yield_stresses]
        yields = [{"label": label, **self.sources[f"yield_stresses.{label}"].document()} for label in labels]
        return {**document, **sections, "yield_stresses": yields}

    def _kind(self, section: str) -> str | None:
        return getattr(getattr(self, section), "kind", None)

    def _choice(self, section: str) -> dict[str, Value]:
        kind = self._kind(section)
        return {"kind": kind} if kind else {}

    def _plain(self, section: str) -> dict[str, Value]:
        return {**self._choice(section), **self._constants(section)}

    def _record(self, section: str) -> type:
        return record_of(section, self._kind(section), section)

    def _constants(self, section: str) -> Mapping[str, float | None]:
        part = getattr(self, section)
        return part.constants if isinstance(part, Model) else vars(part)


# Read by laws, reports and checks and by no simulation: runs that differ in these alone are the same.
NOT_SIMULATED = (*TEXTS, "yield_stresses", "brinell_hardness")
# Of the section of heat: these act where matter opens (solver/matter/tension/opening.py).
OF_OPENING = ("solidus", "liquidus", "heat_to_solidus", "incipient_vaporisation")
# The bulk modulus that acts is that of the equation of state, and the stated one is there to be compared with it; it
# acts where an equation of state takes it.
STIFFNESS = "elastic.bulk_modulus"


def acting_eos(kind: str, form: str = "") -> "EosEntry":
    """The entry of the equation of state of a material, in a form (``eos_form``); its own where it has no such form."""
    every: Mapping[str, EosEntry] = entries("solver.matter.eos", "EOS")
    forms = (eos for eos in every.values() if eos.form and eos.form == form)
    return next((eos for eos in forms if eos.kind == kind or not declared(eos.record)), every[kind])
