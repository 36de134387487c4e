"""Beside simulated walls that hold: how many walls that were perforated such simulations find."""

import math
from collections.abc import Mapping

from service.pages.notes import OutcomeNote
from service.pages.rendering import rendered
from studies.quantities.numerical_defaults import NO_FAILURE
from studies.quantities.parameters import Plain, Value
from studies.shields.shield import WALL_PERFORATED
from studies.shields.shots.drawn import FAST, failures_found

TEMPLATE = "service.shields.pages:walls.txt"


def beside_held(failure: str, normal_speed: float) -> str:
    """What stands beside a wall that holds."""
    return rendered(TEMPLATE, found=failures_found(failure, normal_speed))


def _of_run(value: float, parameters: Mapping[str, Value]) -> str:
    if value:
        return ""
    normal_speed = float(parameters["speed"] or 0.0) * math.cos(float(parameters.get("obliquity") or 0.0))
    return beside_held(str(parameters.get("failure")), normal_speed)


def _of_sweep(document: Mapping[str, Plain]) -> str:
    """By the failures of the runs."""
    axes, fixed = document.get("axes"), document.get("fixed")
    failures = axes.get("failure") if isinstance(axes, Mapping) else None
    if not isinstance(failures, list):
        failures = [fixed.get("failure") if isinstance(fixed, Mapping) else None]
    found = {name: failures_found(name, FAST) for name in (str(failure or NO_FAILURE) for failure in failures)}
    return rendered(TEMPLATE, found=found, fast=FAST / 1e3)


NOTE = OutcomeNote(WALL_PERFORATED, _of_run, _of_sweep)
