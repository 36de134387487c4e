"""Residual velocities by impact speed, with the curve of Recht and Ipson."""

from dataclasses import dataclass

from studies.reports.records import Place
from studies.reports.section import Part, Section, Source

EQUATION = "v_r = a (v^p - v_bl^p)^(1/p)"
SOURCE = "Recht and Ipson (1963), J. Appl. Mech. 30, 384 (recalled, not read)"


@dataclass(frozen=True)
class FittedConstant:
    """A constant with the half of its interval of confidence (95 %, Student's t)."""

    value: float | None
    half_interval: float | None


@dataclass(frozen=True)
class ResidualCurve:
    """Residual velocities (m/s) along the impact speed at one place of the other axes."""

    at: Place
    speed: tuple[float, ...]
    residual_velocity: tuple[float, ...]
    points: int  # that perforate
    too_few: bool  # to fit the constants
    a: FittedConstant | None  # None where it is not fitted
    p: FittedConstant | None
    v_bl: FittedConstant | None


@dataclass(frozen=True)
class ResidualVelocities:
    """The equation with its source, and all curves."""

    equation: str
    source: str
    curves: tuple[ResidualCurve, ...]


def _part(source: Source) -> Part | None:
    from studies.plugs.curve import residual_velocities_of

    return residual_velocities_of(source)


SECTION = Section(
    "residual_velocity", "Residual velocities", 28, ResidualVelocities, _part, "studies.plugs:section.html"
)
