"""Models of a material's matter: a record of the solver for each law, with the constants that its own file names."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache
from itertools import product
from typing import TYPE_CHECKING, Annotated, NamedTuple, Self

from solver.registry import entries
from solver.units import Described, Dimensionless, FromMaterial, Unit, marked
from studies.materials.schema import OPTIONAL, acting_eos, models
from studies.quantities.findings import Finding
from studies.quantities.numerical_defaults import DEFAULT_FAILURE, NO_FAILURE
from studies.quantities.parameters import Choice, Record, declared
from studies.quantities.units import readable
from studies.scenarios import Materials
from studies.scenarios.parts.numerics import tensions

if TYPE_CHECKING:
    from solver.matter.eos import EosEntry, EosRecord
    from solver.matter.failure import FailureEntry, PointLoading
    from solver.matter.laws import Matter
    from studies.materials import Material

HUGONIOT = "hugoniot"  # the form of an equation of state that each material has
PROJECTILES = ("projectile", "flyer")  # the roles whose materials may go without what a failure takes
# A first plastic strain that no failure may break: at 1/s, as in testing machines, and at the rate of impacts (1/s),
# cold and half-way to melting.
FIRST_SLIP, FAST, WARM = 1e-4, 1e5, 0.5


def failures() -> Mapping[str, "FailureEntry"]:
    """Failures by name."""
    return entries("solver.matter.failure", "FAILURE")


def eos_forms() -> dict[str, "EosEntry"]:
    """The equations of state that compute materials of another kind too, by form."""
    return {eos.form: eos for eos in entries("solver.matter.eos", "EOS").values() if eos.form}


def _failure_constants() -> Iterator[tuple[str, str, str]]:
    """Each constant of a failure that a sweep gives: parameter, failure, and field of its record."""
    for kind, entry in failures().items():
        for constant in declared(entry.record):
            yield f"failure_{constant}", kind, constant


def _with_constants(record: type[Record]) -> type[Record]:
    """Add the constants of all failures, None by default, to the fields of a record that is about to be a dataclass."""
    for parameter, kind, constant in _failure_constants():
        own = failures()[kind].record
        about, unit = marked(own, Described)[constant], marked(own, Unit)[constant]
        described = replace(about, meaning=f"{about.meaning}; goes with failure {kind}")
        record.__annotations__[parameter] = Annotated[float | None, unit, described]
        setattr(record, parameter, None)
    return record


@dataclass(frozen=True, kw_only=True)
@_with_constants
class Fracture:
    """What breaks matter for good: the choice of a failure, and the constants of each that a sweep gives."""

    failure: Annotated[
        str | None,
        Choice(failures),
        Described(
            "failure model: none, plastic strain, tension beyond the spall strength for long enough, the spall "
            "strength of plate impacts at the strain rate, that and voids which then grow until they link, the damage "
            "of Johnson and Cook, plain or modified, which weakens, or that and the spall strength at once; by default "
            "void-growth on a grid where one target is hit that has its constants"
        ),
    ] = None
    rubble_friction: Annotated[
        Dimensionless,
        Described(
            "shear strength of failed matter over its pressure, as of rubble: Drucker and Prager without cohesion",
            0.0,
            2.0,
        ),
    ] = 0.0

    @property
    def model(self) -> str:
        """The failure of filled parameters."""
        assert self.failure is not None
        return self.failure

    def filled(self, materials: Materials, default: str = DEFAULT_FAILURE) -> Self:
        """With the default failure where all targets have its constants, and with none elsewhere."""
        if self.failure is not None:
            return self
        targets = {role: material for role, material in materials.items() if role not in PROJECTILES}
        return replace(self, failure=NO_FAILURE if any(_absent(default, targets)) else default)

    def of(self, material: "Material") -> NamedTuple:
        """The solver's record of the failure with the constants of a material; of a projectile without them, none."""
        record = failures()[self.model].record
        if _goes_without(record, material):
            record, stated = failures()[NO_FAILURE].record, {}
        else:
            own = {constant: getattr(self, name) for name, kind, constant in _failure_constants() if kind == self.model}
            stated = {constant: value for constant, value in own.items() if value is not None}
        return record(**material.taken(record), **stated)

    def check(self, materials: Materials) -> Iterator[Finding]:
        """A failure has all numbers that it needs and no others, and lets matter slip before it fails."""
        findings = [*self._missing(materials)]
        yield from findings or self._brittle(materials)

    def _missing(self, materials: Materials) -> Iterator[Finding]:
        """Numbers that a failure lacks, of its own or of a material, and those that belong to another one."""
        for name, kind, constant in _failure_constants():
            value = getattr(self, name)
            needed = declared(failures()[kind].record)[constant].required
            if self.failure == kind and value is None and needed:
                yield Finding(name, "nothing", f"a value for failure {kind}", f"give {name}")
            if self.failure != kind and value is not None:
                cure = f"leave {name} out, or set failure to {kind}"
                yield Finding(name, f"{value:g}", f"no value without failure {kind}", cure)
        if self.failure == NO_FAILURE and self.rubble_friction > 0.0:
            cure = "leave rubble_friction out, or choose a failure"
            yield Finding("rubble_friction", f"{self.rubble_friction:g}", "no rubble without a failure", cure)
        yield from _absent(self.model, materials)

    def _brittle(self, materials: Materials) -> Iterator[Finding]:
        """Materials that fail at their first slip in tension, shear or compression: no matter does."""
        for role, material in materials.items():
            failure = self.of(material)
            at = _first_failure(failure)
            if at is None:
                continue
            where = f"a triaxiality of {at.triaxiality:.2g}, {at.strain_rate:g} /s and T* = {at.homologous:g}"
            limit = f"matter that slips before it fails; {material.name} fails at its first slip under {where}"
            paths = ", ".join(f"{role}.{mark.path}" for mark in marked(type(failure), FromMaterial).values())
            yield Finding("failure", self.model, limit, f"correct {paths}: their signs first")


@cache
def _first_failure(failure: NamedTuple) -> "PointLoading | None":
    """The first load, slow or fast, cold or warm, that breaks whole matter at its first slip; None without one."""
    from solver.matter.failure import PointLoading, grown_damage

    slip = getattr(failure, "threshold", 0.0) + FIRST_SLIP
    for triaxiality, rate, homologous in product((-1.0 / 3.0, 0.0, 1.0 / 3.0), (1.0, FAST), (0.0, WARM)):
        load = PointLoading(slip, FIRST_SLIP, 0.0, triaxiality, rate, homologous, FIRST_SLIP / rate)
        if grown_damage(failure, 0.0, load) >= 1.0:
            return load
    return None


def _absent(failure: str, materials: Materials) -> Iterator[Finding]:
    """The constants that a failure takes from a material, which has none."""
    record = failures()[failure].record
    for role, material in materials.items():
        if role in PROJECTILES and len(materials) > 1 and _goes_without(record, material):
            continue  # a projectile without the section never fails
        for name, value in material.taken(record).items():
            taken = marked(record, FromMaterial)[name]
            if value is None or (value == 0.0 and taken.above_zero):
                meaning = material.parameters[taken.path].meaning
                limit = f"a material with a {meaning}, which {material.name} has not"
                cure = f"set {role}.{taken.path}, or choose another failure"
                yield Finding("failure", failure, limit, cure)


def _goes_without(record: type, material: "Material") -> bool:
    """Whether a failure takes its constants from an optional section, and the material has none of them."""
    paths = [mark.path for mark in marked(record, FromMaterial).values()]
    optional = [path for path in paths if path.partition(".")[0] in OPTIONAL]
    return bool(optional) and all(material.value_at(path) is None for path in optional)


def matter(
    material: "Material",
    *,
    eos_form: str = HUGONIOT,
    thermal_softening: bool | None = True,
    tension: str = "recoverable",
    fracture: Fracture | None = None,
) -> "Matter":
    """The matter of a material; by default it never fails."""
    from solver.matter.laws import Matter
    from solver.matter.melting import MeltingCurve, lindemann

    eos, thermal, melting, rule = eos_of(material, eos_form), material.thermal, MeltingCurve(), tensions()[tension]
    melt = thermal.melt_temperature if thermal_softening else None
    if melt is not None:
        fusion = (thermal.latent_heat_of_fusion or 0.0) / thermal.heat_capacity
        at, density, liquidus = melt, thermal.melting_density, None
        if rule.opens:
            at, density, liquidus = thermal.solidus or melt, None, thermal.liquidus or melt
            if thermal.heat_to_solidus is not None:
                eos = eos_of(material, eos_form, thermal.heat_to_solidus / (at - thermal.room_temperature))
                fusion = (thermal.latent_heat_of_fusion or 0.0) / eos.heat_capacity
            strengths = entries("solver.matter.strength", "STRENGTH")
            melt = melt if strengths[material.strength.kind].melts else liquidus
        melting = lindemann(eos, at, thermal.melting_slope, fusion=fusion, density_ratio=density, liquidus=liquidus)
    if rule.opens and thermal.incipient_vaporisation is not None:
        melting = melting._replace(vaporisation=thermal.incipient_vaporisation)
    constants = material.taken(rule.record)
    if None in constants.values():
        rule, constants = tensions()["unlimited"], {}
    return Matter(
        eos=eos,
        # A constant that the material goes without is infinite.
        strength=models("strength")[material.strength.kind].record(
            **{name: math.inf if value is None else value for name, value in material.fill("strength").items()}
        ),
        tension=rule.record(**constants),
        shear_modulus=material.elastic.shear_modulus,
        room_temperature=thermal.room_temperature,
        melt_temperature=math.inf if melt is None else melt,
        failure=fracture.of(material) if fracture else failures()[NO_FAILURE].record(),
        rubble_friction=fracture.rubble_friction if fracture else 0.0,
        melting=melting,
    )


def eos_of(material: "Material", form: str = HUGONIOT, heat_capacity: float | None = None) -> "EosRecord":
    """The solver's equation of state of a material, in a form, by default with its heat capacity (J/(kg K))."""
    entry = acting_eos(material.eos.kind, form)
    constants = material.fill("eos", entry.record)
    if heat_capacity is not None:
        constants = {**constants, "heat_capacity": heat_capacity}
    eos: EosRecord = entry.make(**constants)
    return eos


def check_eos(form: str, materials: Materials) -> list[Finding]:
    """A form other than the default needs materials that can be written in it."""
    limits: list[str] = []
    for material in materials.values() if form != HUGONIOT else ():
        entry, constants = acting_eos(material.eos.kind, form), material.eos.constants
        if entry.form != form:
            limits.append(f"{material.name} ({material.eos.kind}) has one form")
            continue
        for name, parameter in declared(entry.record).items():
            value, least = constants[name], parameter.minimum
            assert value is not None
            assert least is not None
            if value < least:
                limits.append(f"{material.name} has {name} = {value:g}, and the {form} is for {least:g} and more")
    return [Finding("eos_form", form, f"{HUGONIOT}: {limit}", "leave eos_form out") for limit in limits]


def check_boiling(tension: str, thermal_softening: bool | None, materials: Materials) -> list[Finding]:
    """A form that follows vapour has no tension where it boils, and a step there: melting has to end tension before."""
    if tensions()[tension].molten:
        name, value = "tension", tension
    elif thermal_softening is False:
        name, value = "thermal_softening", "false"
    else:
        return []
    return [
        Finding(
            name,
            value,
            f"tension that melting ends: {material.name} ({material.eos.kind}) would boil under it",
            f"leave {name} out, or choose a {role} with another equation of state",
        )
        for role, material in materials.items()
        if acting_eos(material.eos.kind).boils
    ]


def check_constants(materials: Materials) -> list[Finding]:
    """Constants of a material that make sense only in one order."""
    findings = []
    for role, material in materials.items():
        parameters = material.parameters
        for low, high, may_equal in material.below():
            least, most = material.value_at(low), material.value_at(high)
            if least is None or most is None or least < most or (least == most and may_equal):
                continue
            unit = parameters[low].unit or "1"
            limit = f"{'at most' if may_equal else 'below'} {role}.{high}, {readable(most, unit)}"
            relation = "does not exceed" if may_equal else "lies below"
            meanings = f"{parameters[low].meaning} {relation} {parameters[high].meaning}"
            cure = f"{meanings}: correct one of them"
            findings.append(Finding(f"{role}.{low}", readable(least, unit), limit, cure))
    return findings


def longitudinal_speed(bulk: float, shear: float, density: float) -> float:
    """Speed of an elastic wave of uniaxial strain, m/s."""
    return math.sqrt((bulk + 4.0 / 3.0 * shear) / density)


def yield_stress(material: "Material", strain: float = 0.0) -> float | None:
    """Yield stress of cold, slow matter after a plastic strain, Pa; None of a strength that has none of its own."""
    own = {name: math.inf if value is None else value for name, value in material.strength.constants.items()}
    match material.strength.kind:
        case "johnson-cook" | "modified-johnson-cook":
            return own["A"] + own["B"] * strain ** own["n"] if strain else own["A"]
        case "perfectly-plastic":
            return own["yield_stress"]
        case "linear-hardening":
            return own["yield_stress"] + own["hardening_modulus"] * strain
        case "steinberg-guinan":
            return min(own["Y0"] * (1.0 + own["beta"] * strain) ** own["n"], own["Y_max"])
    return None


def elastic_speed(material: "Material") -> float:
    """Speed of an elastic wave of uniaxial strain in a material, m/s."""
    return longitudinal_speed(material.elastic.bulk_modulus, material.elastic.shear_modulus, material.density)
