"""Every material has a source for each number, and constants that agree."""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from solver.matter.eos import pressure_terms, temperature_at
from solver.matter.failure.johnson_cook import fracture_strain
from solver.units import Described, marked
from studies import materials
from studies.materials import Material
from studies.materials.schema import CONFIDENCES, SECTIONS, Scalars, models
from studies.quantities.parameters import declared
from studies.scenarios.parts.doubts import BULK_MODULUS_AGREEMENT, doubts_of
from studies.scenarios.parts.matter import Fracture, check_constants, check_eos, eos_forms, eos_of, failures
from tests.contracts.test_eos import shock

# Each constant of a failure that a sweep gives: parameter, failure, and field of its record.
FAILURE_CONSTANTS = [
    (f"failure_{name}", kind, name) for kind, entry in failures().items() for name in declared(entry.record)
]

# Accuracy of the solver's kept isentrope (solver/matter/eos/_hugoniot.py): of its energy up to the tangent, and in
# kelvin at the densities of like-on-like shocks up to 10 km/s.
ISENTROPE_ENERGY, ISENTROPE_KELVIN, FASTEST = 1e-3, 1.0, 1e4
SAME_METAL = 0.05  # of the shock speed, between two equations of state


@pytest.fixture(params=materials.names())
def material(request: pytest.FixtureRequest) -> Material:
    return materials.load(request.param)


def test_material__has_a_source_and_a_confidence_for_every_number(material: Material) -> None:
    needed = {path for path in material.paths() if material.value_at(path) is not None}
    needed |= {f"yield_stresses.{stress.label}" for stress in material.yield_stresses}
    assert needed <= set(material.sources)
    for quantity in material.sources.values():
        assert len(quantity.source) > 10
        assert quantity.confidence in set(CONFIDENCES) - {"user"}


def test_material__loads_from_its_own_document(material: Material) -> None:
    assert materials.read_own(material.document()) == material
    assert Material.from_resolved(material.resolved()) == material


def test_material__has_constants_that_agree(material: Material) -> None:
    G, K = material.elastic.shear_modulus, material.elastic.bulk_modulus
    from_sound_speed = material.density * material.sound_speed**2
    assert math.isclose(from_sound_speed, K, rel_tol=BULK_MODULUS_AGREEMENT)
    assert 0.2 < (3 * K - 2 * G) / (6 * K + 2 * G) < 0.48  # Poisson's ratio of a metal
    assert check_constants({"target": material}) == []
    assert list(doubts_of(material)) == []


def test_material__has_no_failure_at_its_first_slip(material: Material) -> None:
    given = {parameter: 1e-6 if parameter.endswith("time") else 0.5 for parameter, _, _ in FAILURE_CONSTANTS}
    for kind in failures():
        mine = {parameter: given[parameter] for parameter, of, _ in FAILURE_CONSTANTS if of == kind}
        findings = Fracture(failure=kind, **mine).check({"target": material})
        assert not [finding for finding in findings if "first slip" in finding.limit]


# Coefficients of a fit say nothing one by one.
OF_A_FIT = {"eos.polynomial": {"C0", "C2", "C3", "C4", "C5", "C6"}}


def _records() -> Iterator[tuple[str, type]]:
    """Each record of constants of matter, with the place of its constants."""
    yield "", Scalars
    for section, chosen in SECTIONS.items():
        if isinstance(chosen, type):
            yield section, chosen
        else:
            yield from ((f"{section}.{kind}", entry.record) for kind, entry in models(section).items())
    yield from ((f"failure.{kind}", entry.record) for kind, entry in failures().items())


@pytest.mark.parametrize(("place", "record"), [*_records()])
def test_constant__has_bounds_and_a_usual_range_within_them(place: str, record: type) -> None:
    """Sign and range from its meaning, beside the field; zero where matter goes without."""
    for name, about in marked(record, Described).items():
        assert about.minimum is not None
        assert about.maximum is not None
        assert (about.usual is None) == (name in OF_A_FIT.get(place, ())), f"{place}.{name} has no usual range"
        if about.usual is not None:
            low, high = about.usual
            assert about.minimum <= low < high <= about.maximum


def test_material__states_yield_stresses_for_the_laws(material: Material) -> None:
    labels = [stress.label for stress in material.yield_stresses]
    assert labels
    assert len(set(labels)) == len(labels)
    assert all(stress.value < material.elastic.shear_modulus for stress in material.yield_stresses)


@pytest.mark.parametrize("form", sorted(set(eos_forms()) - {"elastic"}))  # which heats nothing
def test_material__has_the_temperature_of_its_isentrope(material: Material, form: str) -> None:
    """Against an isentrope integrated here, de = p drho / rho^2 and dT / T = dp/de drho / rho^2."""
    if material.eos.kind == "linear-elastic":
        pytest.skip("linear elasticity heats nothing")
    if check_eos(form, {"target": material}):
        pytest.skip(f"{material.eos.kind} has one form")
    eos: Any = eos_of(material, form)

    def slope(density: float, state: np.ndarray) -> np.ndarray:
        a, b = pressure_terms(eos, density, float(state[0]))
        return np.array([a + b * state[0], b]) / density**2

    densities = material.density * (1.0 + eos.mu_tangent * np.linspace(0.0, 1.0, 101)[1:])
    solution = solve_ivp(
        slope, (material.density, densities[-1]), [0.0, 0.0], method="DOP853", t_eval=densities, rtol=1e-11, atol=1e-6
    )
    energies, heated = solution.y
    kelvin = [temperature_at(eos, *point) for point in zip(densities, energies, strict=True)]
    missed = np.abs(np.array(kelvin) - material.thermal.room_temperature * np.exp(heated))
    assert np.all(missed * material.thermal.heat_capacity <= ISENTROPE_ENERGY * energies)
    reached = densities <= shock(eos, 0.5 * FASTEST, least_slope=1.0)[2]
    assert reached.sum() > 10
    assert np.all(missed[reached] <= ISENTROPE_KELVIN)


@pytest.mark.parametrize("up", [1e3, 3e3])
def test_tillotson__has_the_shocks_of_the_same_metal_about_its_hugoniot(up: float) -> None:
    """Two fits of the same measured shocks: what their authors call good is a few per cent of the speed."""
    pairs = [(name, name.removesuffix("-tillotson")) for name in materials.names() if "tillotson" in name]
    assert pairs
    for mine, other in pairs:
        speeds = [shock(eos_of(materials.load(name)), up)[0] for name in (mine, other)]
        assert math.isclose(*speeds, rel_tol=SAME_METAL), (mine, speeds)


# Triaxialities of Johnson and Cook's tests: from a bar in compression to a deep notch. Sets with D1 below zero end at a
# higher one, where matter fails at its next slip: 6061-T6 at 1.35, Armco iron at 1.92, 7075-T6 at 1.99.
TESTED = np.linspace(-1.0 / 3.0, 1.0, 41)


@pytest.mark.parametrize("name", [name for name in materials.names() if materials.load(name).fracture.D1 is not None])
def test_fracture_strain__is_positive_and_falls_with_triaxiality(name: str) -> None:
    """The sign of D3 is that of a triaxiality that is positive in tension."""
    failure = Fracture(failure="johnson-cook").of(materials.load(name))
    strains = np.array([fracture_strain(failure, triaxiality, 1.0, 0.0) for triaxiality in TESTED])
    assert np.all(strains > 0.0)
    assert np.all(np.diff(strains) < 0.0)
