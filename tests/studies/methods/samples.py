"""Samples of other methods for the tests that all scenarios share."""

from typing import Any

QUARTER = {
    "geometry": "quarter",
    "cells_per_diameter": 6.0,
    "plate_thickness": 2e-3,
    "plate_radius": 16e-3,
    "end_time": 2e-6,
}
MESHED = {"geometry": "quarter", "section": "square", "wall": "symmetric"}
CASES: dict[str, tuple[str, dict[str, Any]]] = {
    "thin plate, sph": ("thin_plate", {**QUARTER, "method": "sph"}),
    **{f"elastic bar, {method}": ("elastic_bar", {**MESHED, "method": method}) for method in ("sph", "fem", "sph-fem")},
}
LONG = {"thin plate, sph"}


def plate(name: str, value: str) -> tuple[str, dict[str, Any], str, str]:
    return "thin_plate", {"geometry": "quarter", "method": "sph", name: value}, name, "method sph"


def bar(method: str, name: str, value: str) -> tuple[str, dict[str, Any], str, str]:
    return "elastic_bar", {**MESHED, "method": method, name: value}, name, f"method {method}"


# What a method does not compute.
REFUSED: list[tuple[str, dict[str, Any], str, str]] = [
    plate("geometry", "axisymmetric"),
    plate("edges", "absorbing"),
    plate("contact", "bardenhagen"),
    plate("debris", "retire"),
    bar("fem", "section", "round"),
    ("elastic_bar", {"method": "fem"}, "geometry", "method fem"),
    bar("sph", "wall", "unilateral"),
    bar("fem", "scheme", "usl"),
]
