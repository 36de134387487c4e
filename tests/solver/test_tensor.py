"""Symmetric tensors against full matrices, and the rotation that keeps invariants."""

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from solver.matter.tensor import (
    PlaneGradient,
    deviator,
    equivalent_strain,
    equivalent_stress,
    rotated,
    spin_increment,
    strain_increment,
    symmetric,
    turned,
    volume_ratio,
)

ROUND_OFF = 1e-12
component = st.floats(-1e9, 1e9)
tensors = st.tuples(*[component] * 6)
spins = st.tuples(*[st.floats(-10.0, 10.0)] * 3)
gradients = st.lists(st.floats(-1e6, 1e6), min_size=9, max_size=9).map(lambda numbers: np.array(numbers).reshape(3, 3))


def matrix(a: tuple[float, ...]) -> np.ndarray:
    """Components 11 22 33 12 23 31 as a matrix."""
    return np.array([[a[0], a[3], a[5]], [a[3], a[1], a[4]], [a[5], a[4], a[2]]])


def skew(spin: tuple[float, ...]) -> np.ndarray:
    """W with W x = spin cross x."""
    x, y, z = spin
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def norm(a: tuple[float, ...]) -> float:
    return float(np.linalg.norm(matrix(a)))


def test_equivalents__of_a_pull_and_of_shear_are_the_textbook_ones() -> None:
    """The pull itself, and root three times the shear stress."""
    assert math.isclose(equivalent_stress(deviator((6e8, 0.0, 0.0, 0.0, 0.0, 0.0), 6e8)), 6e8)
    assert math.isclose(equivalent_stress((0.0, 0.0, 0.0, 1e8, 0.0, 0.0)), math.sqrt(3.0) * 1e8)
    assert math.isclose(equivalent_strain((0.1, -0.05, -0.05, 0.0, 0.0, 0.0)), 0.1)


@given(gradients)
def test_gradient__is_strain_plus_spin(gradient: np.ndarray) -> None:
    dt = 1e-8
    strain, trace = strain_increment(gradient, dt)
    whole = matrix(strain) + skew(spin_increment(gradient, dt))
    assert np.allclose(whole, gradient * dt, rtol=0.0, atol=1e6 * dt * ROUND_OFF)
    assert math.isclose(trace, np.trace(gradient) * dt, rel_tol=1e-9, abs_tol=1e6 * dt * ROUND_OFF)


@given(gradients)
def test_volume_ratio__is_the_determinant_of_the_step(gradient: np.ndarray) -> None:
    dt = 1e-7
    expected = np.linalg.det(np.eye(3) + gradient * dt)
    assert math.isclose(volume_ratio(gradient, dt), expected, rel_tol=ROUND_OFF, abs_tol=ROUND_OFF)


@given(tensors, spins)
def test_rotated__is_the_cayley_transform(a: tuple[float, ...], spin: tuple[float, ...]) -> None:
    half = 0.5 * skew(spin)
    turn = np.linalg.solve(np.eye(3) - half, np.eye(3) + half)
    expected = turn @ matrix(a) @ turn.T
    assert np.allclose(matrix(rotated(a, spin)), expected, rtol=0.0, atol=(norm(a) + 1e-300) * ROUND_OFF)


@given(tensors, gradients)
def test_plane_gradient__does_what_the_same_rows_do(a: tuple[float, ...], gradient: np.ndarray) -> None:
    dt = 1e-6
    for j, k in ((0, 2), (1, 2), (2, 0), (2, 1)):
        gradient[j, k] = 0.0
    a = (*a[:4], 0.0, 0.0)
    plane = PlaneGradient(*map(tuple, gradient.tolist()))
    assert symmetric(plane) == symmetric(gradient)
    assert math.isclose(volume_ratio(plane, dt), volume_ratio(gradient, dt), abs_tol=ROUND_OFF)
    expected = rotated(a, spin_increment(gradient, dt))
    assert np.allclose(turned(plane, a, dt), expected, rtol=0.0, atol=norm(a) * ROUND_OFF)
    assert np.allclose(turned(gradient, a, dt), expected, rtol=0.0, atol=0.0)
