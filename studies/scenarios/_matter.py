"""A material becomes what the solver computes with: one record for each law."""

import math
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any, Literal

from solver.registry import entries
from solver.units import Dimensionless, Second
from studies.materials.schema import MieGrueneisen, Tillotson
from studies.scenarios import Materials
from studies.scenarios._fields import described, explained
from studies.scenarios._numerics import filled_numerics
from studies.values.errors import Finding
from studies.values.quantities import readable
from studies.values.recipes import Tension

if TYPE_CHECKING:
    from solver.problem import Matter
    from studies.materials import Material

EosForm = Literal["hugoniot", "cubic"]
Failure = Literal["none", "plastic-strain", "spall"]

EOS_FORMS = {"hugoniot": "mie_grueneisen", "cubic": "mie_grueneisen_cubic"}  # of mie-grueneisen

# Constants whose first lies below the second, or may equal it, and what to do where it does not.
ORDERED = (
    ("eos.e_iv", "eos.e_cv", False, "boiling begins at e_iv and ends at e_cv: correct one of them"),
    ("strength.Y0", "strength.Y_max", True, "metal hardens from Y0 to Y_max: correct one of them"),
    (
        "thermal.room_temperature",
        "thermal.melt_temperature",
        False,
        "a liquid bears no shear and makes no shield: correct one of them",
    ),
)


@dataclass(frozen=True, kw_only=True)
class Fracture:
    """Parameters of what breaks matter for good."""

    failure: Failure = explained(
        "what breaks matter for good: nothing, plastic strain, or tension beyond the spall strength for long enough",
        default="none",
    )
    failure_strain: Dimensionless | None = described(
        "plastic strain at which matter fails; goes with failure plastic-strain",
        1e-3,
        100.0,
        default=None,
    )
    failure_time: Second | None = described(
        "time at twice the spall strength after which matter fails, without a tensile floor; goes with failure spall",
        1e-12,
        1.0,
        default=None,
    )


def matter(
    material: "Material",
    *,
    eos_form: EosForm = "hugoniot",
    thermal_softening: bool = True,
    tension: Tension = "recoverable",
    failure: Any = None,
) -> "Matter":
    """The matter of a material; ``failure`` is a record of the solver, by default matter never fails."""
    from solver.failure.none import NoFailure
    from solver.problem import Matter
    from solver.tension.recoverable import RecoverableTension
    from solver.tension.unlimited import UnlimitedTension

    spall = material.tension.spall_strength if tension == "recoverable" else None
    melt = material.thermal.melt_temperature if thermal_softening else None
    return Matter(
        eos=eos_of(material, eos_form),
        strength=_strength(material),
        tension=UnlimitedTension() if spall is None else RecoverableTension(spall),
        shear_modulus=material.elastic.shear_modulus,
        room_temperature=material.thermal.room_temperature,
        melt_temperature=math.inf if melt is None else melt,
        failure=failure or NoFailure(),
    )


def eos_of(material: "Material", form: EosForm = "hugoniot") -> Any:
    """The solver's record of a material's equation of state; only Mie and Grueneisen's is written in several forms."""
    name = material.eos.kind
    chosen = EOS_FORMS[form] if name == MieGrueneisen.kind else name.replace("-", "_")
    return entries("solver.eos", "EOS")[chosen].make(
        density=material.density,
        heat_capacity=material.thermal.heat_capacity,
        temperature=material.thermal.room_temperature,
        **asdict(material.eos),
    )


def check_eos(form: EosForm, materials: Materials) -> list[Finding]:
    """A form other than the default needs materials that can be written in it."""
    if form == "hugoniot":
        return []
    one_form = [
        Finding(
            "eos_form",
            form,
            f"hugoniot: {material.name} ({material.eos.kind}) has one form",
            "leave eos_form out",
        )
        for material in materials.values()
        if not isinstance(material.eos, MieGrueneisen)
    ]
    # The last term of the cubic is negative for 1/3 < s < 1, and its curve turns down in compression.
    downwards = [
        Finding(
            "eos_form",
            form,
            f"hugoniot: {material.name} has s = {material.eos.s:g}, and the cubic is for 1 and more",
            "leave eos_form out",
        )
        for material in materials.values()
        if isinstance(material.eos, MieGrueneisen) and material.eos.s < 1.0
    ]
    return one_form + downwards


def check_boiling(given: Any, materials: Materials) -> list[Finding]:
    """A form that follows vapour has no tension from e_iv on, and a step there: melting has to end tension before."""
    if filled_numerics(given).tension == "unlimited":
        name, value = "tension", "unlimited"
    elif not given.thermal_softening:
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
        if isinstance(material.eos, Tillotson)
    ]


def check_constants(materials: Materials) -> list[Finding]:
    """Constants of a material that make sense only in one order."""
    findings = []
    for role, material in materials.items():
        parameters = material.parameters()
        for low, high, may_equal, cure in ORDERED:
            if not {low, high} <= set(parameters):
                continue
            least, most = material.value_at(low), material.value_at(high)
            if least is None or most is None or least < most or (least == most and may_equal):
                continue
            unit = parameters[low].unit or "1"
            limit = f"{'at most' if may_equal else 'below'} {role}.{high}, {readable(most, unit)}"
            findings.append(Finding(f"{role}.{low}", readable(least, unit), limit, cure))
    return findings


def failure_of(given: Fracture, material: "Material") -> Any:
    """The solver's record of the failure that the parameters name, with the constants of the material."""
    from solver.failure.none import NoFailure
    from solver.failure.plastic_strain import PlasticStrainLimit
    from solver.failure.spall import Spall

    if given.failure == "plastic-strain":
        assert given.failure_strain is not None
        return PlasticStrainLimit(given.failure_strain)
    if given.failure == "spall":
        assert given.failure_time is not None
        assert material.tension.spall_strength is not None
        return Spall(material.tension.spall_strength, given.failure_time)
    return NoFailure()


def check_failure(given: Fracture, materials: Materials) -> list[Finding]:
    """A failure has the number that it needs, no other one, and a spall strength of each material."""
    needed = {"plastic-strain": "failure_strain", "spall": "failure_time"}
    findings = []
    for kind, name in needed.items():
        value = getattr(given, name)
        if given.failure == kind and value is None:
            findings.append(Finding(name, "nothing", f"a value for failure {kind}", f"give {name}"))
        if given.failure != kind and value is not None:
            limit = f"no value without failure {kind}"
            cure = f"leave {name} out, or set failure to {kind}"
            findings.append(Finding(name, f"{value:g}", limit, cure))
    if given.failure == "spall":
        findings += [
            Finding(
                "failure",
                "spall",
                f"a material with a spall strength, which {material.name} has not",
                f"set {role}.tension.spall_strength, or choose another failure",
            )
            for role, material in materials.items()
            if not material.tension.spall_strength
        ]
    return findings


def _strength(material: "Material") -> Any:
    """The solver's record of the same name and fields; a constant that the material goes without is infinite."""
    name = material.strength.kind.replace("-", "_")
    constants = {
        field: math.inf if value is None else value
        for field, value in asdict(material.strength).items()
    }
    return entries("solver.strength", "STRENGTH")[name].record(**constants)
