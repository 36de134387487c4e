"""Models of a material's matter: one record of the solver for each law, with the constants of the material.

The models are those of the folders ``solver/matter/eos``, ``strength``, ``tension`` and ``failure``; which constants
they take, and from where, stands in their own files.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, make_dataclass, replace
from functools import cache
from itertools import product
from typing import TYPE_CHECKING, Annotated, Any, Self

from solver.registry import entries
from solver.units import Described, Dimensionless, FromMaterial, Unit, marked
from studies.materials.schema import OPTIONAL, acting_eos, models
from studies.quantities.findings import Finding
from studies.quantities.numerical_defaults import DEFAULT_FAILURE, NO_FAILURE
from studies.quantities.parameters import Choice, declared
from studies.quantities.units import readable
from studies.scenarios import Materials
from studies.scenarios.parts.numerics import tensions

if TYPE_CHECKING:
    from solver.matter.failure import PointLoading
    from solver.matter.laws import Matter
    from solver.matter.melting import MeltingCurve
    from studies.materials import Material

HUGONIOT = "hugoniot"  # the form of an equation of state that each material has
PROJECTILES = ("projectile", "flyer")  # the roles whose materials may go without what a failure takes
# What each failure has to bear: a plastic strain, at the rates (1/s) of tests in machines and of impacts, cold and
# half-way to melting.
FIRST_SLIP, FAST, WARM = 1e-4, 1e5, 0.5


def failures() -> Mapping[str, Any]:
    """Failures by name."""
    return entries("solver.matter.failure", "FAILURE")


def eos_forms() -> dict[str, Any]:
    """The equations of state that compute materials of another kind too, by form."""
    return {eos.form: eos for eos in entries("solver.matter.eos", "EOS").values() if eos.form}


def _failure_constants() -> Iterator[tuple[str, str, str]]:
    """Each constant of a failure that a sweep gives: parameter, failure, and field of its record."""
    for kind, entry in failures().items():
        for constant in declared(entry.record):
            yield f"failure_{constant}", kind, constant


def _failure_parameter(kind: str, constant: str) -> Any:
    """The annotation of a parameter: that of the failure's own record, or None."""
    record = failures()[kind].record
    about, unit = marked(record, Described)[constant], marked(record, Unit)[constant]
    meaning = f"{about.meaning}; goes with failure {kind}"
    mark = Described(meaning, about.minimum, about.maximum, usual=about.usual)
    return Annotated[float | None, unit, mark]


# Each constant of a failure is a parameter of every impact; a run that does not give it keeps its identity.
_FailureParameters: Any = make_dataclass(
    "_FailureParameters",
    [
        (
            "failure",
            Annotated[
                str | None,
                Choice(failures),
                Described(
                    "failure model: none, plastic strain, tension beyond the spall strength for long enough, the spall "
                    "strength of plate impacts at the strain rate, that and voids which then grow until they link, the "
                    "damage of Johnson and Cook, plain or modified, which weakens, or that and the spall strength at "
                    "once; by default void-growth on a grid where one target is hit that has its constants"
                ),
            ],
            field(default=None),
        ),
        (
            "rubble_friction",
            Annotated[
                Dimensionless,
                Described(
                    "shear strength of failed matter over its pressure, as of rubble: Drucker and Prager without "
                    "cohesion",
                    0.0,
                    2.0,
                ),
            ],
            field(default=0.0),
        ),
        *(
            (parameter, _failure_parameter(kind, constant), field(default=None))
            for parameter, kind, constant in _failure_constants()
        ),
    ],
    namespace={"__module__": __name__},
    frozen=True,
    kw_only=True,
)


@dataclass(frozen=True, kw_only=True)
class Fracture(_FailureParameters):
    """What breaks matter for good: the choice of a failure, and the constants of each that a sweep gives."""

    def filled(self, materials: Materials, default: str = DEFAULT_FAILURE) -> Self:
        """With the default failure where all targets have its constants, and with none elsewhere."""
        if self.failure is not None:
            return self
        targets = {role: material for role, material in materials.items() if role not in PROJECTILES}
        failure = NO_FAILURE if any(_absent(default, targets)) else default
        return replace(self, failure=failure)  # type: ignore[call-arg]  # a field of a class that is made at run time

    def of(self, material: "Material") -> Any:
        """The solver's record of the failure, with the constants of a material.

        A projectile without the section that the failure takes its constants from never fails.
        """
        record = failures()[self.failure].record
        if _goes_without(record, material):
            return failures()[NO_FAILURE].record()
        constants = {
            constant: getattr(self, parameter)
            for parameter, kind, constant in _failure_constants()
            if kind == self.failure and getattr(self, parameter) is not None
        }
        return record(**material.taken(record), **constants)

    def check(self, materials: Materials) -> Iterator[Finding]:
        """A failure has the numbers that it needs, no other ones, and such that matter slips before it fails."""
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
        yield from _absent(self.failure, materials)

    def _brittle(self, materials: Materials) -> Iterator[Finding]:
        """Materials that fail at their first slip in tension, shear or compression: no matter does."""
        for role, material in materials.items():
            failure = self.of(material)
            record: Any = type(failure)
            at = _first_failure(failure)
            if at is None:
                continue
            where = f"a triaxiality of {at.triaxiality:.2g}, {at.strain_rate:g} /s and T* = {at.homologous:g}"
            limit = f"matter that slips before it fails; {material.name} fails at its first slip under {where}"
            paths = ", ".join(f"{role}.{mark.path}" for mark in marked(record, FromMaterial).values())
            yield Finding("failure", str(self.failure), limit, f"correct {paths}: their signs first")


@cache
def _first_failure(failure: Any) -> "PointLoading | None":
    """What breaks whole matter at its first slip, of compression, shear and tension, slow and fast, cold and warm."""
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


def _goes_without(record: Any, material: "Material") -> bool:
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
    failure: Any = None,
    rubble_friction: float = 0.0,
) -> "Matter":
    """The matter of a material; ``failure`` is a record of the solver, by default matter never fails."""
    from solver.matter.laws import Matter

    eos = eos_of(material, eos_form)
    melt = material.thermal.melt_temperature if thermal_softening else None
    strength = models("strength")[material.strength.kind].record
    return Matter(
        eos=eos,
        # A constant that the material goes without is infinite.
        strength=strength(**{k: _or_infinite(v) for k, v in material.fill("strength").items()}),
        tension=_tension(material, tension),
        shear_modulus=material.elastic.shear_modulus,
        room_temperature=material.thermal.room_temperature,
        melt_temperature=_or_infinite(melt),
        failure=failure or failures()[NO_FAILURE].record(),
        rubble_friction=rubble_friction,
        melting=_melting(material, eos, melt),
    )


def _melting(material: "Material", eos: Any, melt: float | None) -> "MeltingCurve":
    """The melting curve of a material through its melting point (K), and its heat of fusion."""
    from solver.matter.melting import MeltingCurve, lindemann

    if melt is None:
        return MeltingCurve()
    thermal = material.thermal
    fusion = (thermal.latent_heat_of_fusion or 0.0) / thermal.heat_capacity
    return lindemann(eos, melt, thermal.melting_slope, fusion=fusion, density_ratio=thermal.melting_density)


def _or_infinite(value: float | None) -> float:
    return math.inf if value is None else value


def _tension(material: "Material", name: str) -> Any:
    record = tensions()[name].record
    constants = material.taken(record)
    return tensions()["unlimited"].record() if None in constants.values() else record(**constants)


def eos_of(material: "Material", form: str = HUGONIOT) -> Any:
    """The solver's record of a material's equation of state, in one of the forms of its kind."""
    eos = acting_eos(material.eos.kind, form)
    return eos.make(**material.fill("eos", eos.record))


def check_eos(form: str, materials: Materials) -> list[Finding]:
    """A form other than the default needs materials that can be written in it."""
    findings = []
    for material in materials.values():
        entry = acting_eos(material.eos.kind, form)
        if form == HUGONIOT:
            continue
        limits = []
        if entry.form != form:
            limits.append(f"{material.name} ({material.eos.kind}) has one form")
        for name, parameter in declared(entry.record).items():
            value = material.eos.constants[name]
            assert value is not None
            assert parameter.minimum is not None
            if entry.form == form and value < parameter.minimum:
                limits.append(
                    f"{material.name} has {name} = {value:g}, and the {form} is for {parameter.minimum:g} and more"
                )
        findings += [Finding("eos_form", form, f"{HUGONIOT}: {limit}", "leave eos_form out") for limit in limits]
    return findings


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
    own: Mapping[str, Any] = material.strength.constants
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
