"""Flights that are not along the target's normal, and cylinders that do not fly along their axis."""

import math
from dataclasses import dataclass
from typing import Annotated

from solver.units import Described, Radian
from studies.scenarios._impact import Impact
from studies.values.errors import Finding

# Beyond, a projectile skids along a plate that is too small to hold its path.
STEEPEST = math.radians(75.0)


@dataclass(frozen=True, kw_only=True)
class Oblique:
    """Directions of a projectile's flight and axis in the plane of symmetry of a half model."""

    obliquity: Annotated[
        Radian,
        Described("angle between the flight and the target's normal; needs geometry half", 0.0, STEEPEST, neutral=True),
    ] = 0.0
    yaw: Annotated[
        Radian,
        Described(
            "angle between the axis of a cylinder and its flight, positive where its nose is ahead along the target; "
            "needs geometry half",
            -0.5 * math.pi,
            0.5 * math.pi,
            neutral=True,
        ),
    ] = 0.0


def check_oblique(parameters: Impact) -> list[Finding]:
    """Angles need a model that has no other symmetry than theirs, and yaw needs an axis."""
    findings = []
    for name in ("obliquity", "yaw"):
        angle = getattr(parameters, name)
        text = f"{math.degrees(angle):g} deg"
        if angle and parameters.geometry != "half":
            limit = "0 deg in a body of revolution or a quarter model"
            findings.append(Finding(name, text, limit, "set geometry to half"))
        if name == "yaw" and angle and parameters.projectile_shape != "cylinder":
            findings.append(Finding(name, text, "0 deg for a sphere", "use a cylinder"))
    return findings
