"""Craters in the copper block of Ma (2005), section 3.2: 80 x 80 x 40 mm, perfectly plastic, Table 3.2, cells of 1 mm.

A sphere of 0.5 g at 6 km/s by criterion of contact (section 3.2.1, Table 3.3): the thesis' contact raised the kinetic
energy at the first touch (Fig. 3.7) and made the crater larger; energy that contact takes or gives is an error of the
discretisation, and falls with the cell. Its printed criterion stands beside ours.

A cylinder at 4 to 7 km/s (section 3.2.2, Table 3.4). The published numbers are computed ones, on cells of 1 mm, and are
the table of shots ``craters-thesis``. How the thesis reads a diameter is not said. Ours, at the original surface,
misses the tolerance at 5 km/s in the half model, by 0.2 mm of 3 mm: the mouth widens to the end. At 30 us version 5 of
the diameter, from which the present one differs by up to 0.2 mm, had the published ones within 1 mm (24.0, 25.9, 28.7
and 30.1 mm); from there to 45 us it grew by 0.6, 2.4, 2.0 and 2.9 mm, the depth by 0.9 mm at most. The figures of the
thesis are of 45 us.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np
import xarray as xr

from studies.cases.compared import (
    ComparedReading,
    Picture,
    PublishedNumber,
    against,
    compared,
    energy_line,
    grids_of,
    kinetic_energy,
)
from studies.cases.validation import Cubes, Document, ValidationCase, ValidationLevel, numbers_of, of_observations
from studies.fits.fit import fit, forms_of
from studies.fits.forms import Form
from studies.fits.measured import MeasuredShots, of_table
from studies.quantities.comparison import Comparison, at_most, reported
from studies.quantities.parameters import Plain
from studies.quantities.units import round_quantity

CELL = 1e-3  # m, of the thesis
MESH = "cells of 1 mm"
FIXED: Document = {
    "projectile": "copper-thesis-plastic",
    "target": "copper-thesis-plastic",
    "recipe": "thesis",
    "target_depth": "40 mm",
    "target_radius": "40 mm",
    "edges": "fixed",
    "thermal_softening": False,
    "tension": "unlimited",
    "stop": "end_time",
}
REFINED = (1.0, 2.0, 4.0)  # of the fine level, cells of the thesis over the cells


def _craters(level: ValidationLevel, diameter: float, end_time: str, **fixed: Plain) -> Document:
    """Parameters and resolutions of a crater at a level: a body of revolution, or the thesis' half model."""
    cells = diameter / CELL
    return {
        "scenario": "thick_plate",
        "fixed": {
            **FIXED,
            "projectile_diameter": f"{1e3 * diameter:.12g} mm",
            "geometry": "half" if level == "thesis" else "axisymmetric",
            "end_time": end_time,
            **fixed,
        },
        "resolution": [finer * cells for finer in REFINED] if level == "fine" else cells,
    }


# ---- a sphere, by criterion of contact -----------------------------------------------------------

# 0.5 g of copper of 8930 kg/m3: Ma (2005), Table 3.2.
SPHERE = round_quantity((6.0 * 0.5e-3 / (math.pi * 8930.0)) ** (1.0 / 3.0))  # m

# Of the experiment, as the project's reference asks of craters against experiments; the figures on cells of 1 mm were
# known when this was written: 15 mm and 25 mm.
SHARE = 0.15
RISE = 1e-9  # of the kinetic energy, over the initial one: round-off of its sum
CONTACTS = {"none": "no contact", "bardenhagen": "contact", "thesis": "contact by the printed criterion"}


def _contact_sweeps(level: ValidationLevel) -> Mapping[str, Document]:
    crater = _craters(level, SPHERE, "32 us", speed="6 km/s")
    title = "Crater of a copper sphere of 0.5 g at 6 km/s: Ma (2005), Table 3.3"
    contacts = list(CONTACTS)[:2] if level == "quick" else list(CONTACTS)
    return {"contact": {"title": title, "axes": {"contact": contacts}, **crater}}


def _contact_rows(level: ValidationLevel, cubes: Cubes) -> Iterator[Comparison]:
    cube, numbers = cubes["contact"], numbers_of("table_3_3", "thick_plate")
    contacts = {str(contact): CONTACTS[str(contact)] for contact in cube.contact.values}
    mesh = (round_quantity(SPHERE / CELL), MESH)
    for contact, words in contacts.items():
        for name in ("crater_depth", "crater_diameter"):
            quantity = ComparedReading(cube, name, {"contact": contact})
            share = SHARE if contact == "none" else None
            yield from compared(words, quantity, numbers, "experiment", mesh=mesh, share=share)
    for contact, words in contacts.items():
        for cells, run in _runs(cubes, contact):
            where = f"{words}, {cells}"
            kinetic = kinetic_energy(run)[1]
            rise = float(np.max(kinetic) / kinetic[0] - 1.0)
            row = at_most(f"{where}: rise of the kinetic energy above the initial one (Fig. 3.7)", limit=RISE, got=rise)
            yield row if contact != "thesis" else row.ungated(RISE)
            yield reported(
                f"{where}: energy that contact removed (of the initial)", float(run.audit_contact_energy_fraction)
            )


def _runs(cubes: Cubes, contact: str) -> Iterator[tuple[str, xr.Dataset]]:
    """The runs with or without contact, coarse to fine, with the size of their cells in words."""
    for cells, run in grids_of(cubes["contact"].sel(contact=contact)):
        yield f"cells of {1e3 * SPHERE / cells:.3g} mm", run


def _contact_pictures(cubes: Cubes) -> Iterator[Picture]:
    lines = [
        energy_line(f"{words}, {cells}", run)
        for contact, words in CONTACTS.items()
        if contact in cubes["contact"].contact.values
        for cells, run in _runs(cubes, contact)
    ]
    title = "Kinetic energy with and without contact (Fig. 3.7)"
    yield Picture("table-3-3-energy", title, "time (µs)", "kinetic energy (J)", tuple(lines))


# ---- a cylinder, by speed ------------------------------------------------------------------------

CYLINDER = 5e-3  # m
THESIS = "MPM3D (Ma 2005)"
# Two cells in depth, and a cell and a half on either side: what a reading on such a grid can differ by.
WITHIN = {"crater_depth": 2.0, "crater_diameter": 3.0}  # mm
FORMS = ("linear", "power")


def _speed_sweeps(level: ValidationLevel) -> Mapping[str, Document]:
    shape = {"projectile_shape": "cylinder", "projectile_length": "4 mm"}
    crater = _craters(level, CYLINDER, "45 us", **shape)
    speeds = [f"{speed} km/s" for speed in (4, 5, 6, 7)]
    title = "Craters in a copper block: Ma (2005), Table 3.4"
    return {"craters": {"title": title, "axes": {"speed": speeds}, **crater}}


def _numbers() -> list[PublishedNumber]:
    return of_observations("craters-thesis", "thick_plate", THESIS)


def _speed_rows(level: ValidationLevel, cubes: Cubes) -> Iterator[Comparison]:
    cube, numbers = cubes["craters"], _numbers()
    for name, within in WITHIN.items():
        for speed in cube.speed.values:
            quantity = ComparedReading(cube, name, {"speed": float(speed)})
            there = [each for each in numbers if each.shot.parameters["speed"] == speed]
            where = f"{speed / 1e3:g} km/s"
            yield from compared(where, quantity, there, THESIS, mesh=(CYLINDER / CELL, MESH), within=within)
    yield from _fits(cubes)


def _fits(cubes: Cubes) -> Iterator[Comparison]:
    """Line and power through the published points and through ours, with the root of the mean square; mm, km/s."""
    for published in of_table("craters-thesis", list(WITHIN)):
        for form in forms_of(published.quantity):
            if form.name in FORMS:
                texts = [_fitted(each, form) for each in (published, _ours(cubes, published))]
                words = published.quantity.replace("_", " ")
                claim = f"{words}, {form.equation.replace('y/d', 'y')}; y in mm (rms in mm)"
                yield Comparison(claim, texts[0], texts[1], None)


def _ours(cubes: Cubes, published: MeasuredShots) -> MeasuredShots:
    """The published points with our sizes, whatever their flags."""
    values = [
        ComparedReading(cubes["craters"], published.quantity, {"speed": shot.speed}).best[0] / 1e3
        for shot in published.shots
    ]
    return replace(published, values=np.array(values), errors=None)


def _fitted(measured: MeasuredShots, form: Form) -> str:
    if not np.isfinite(measured.values).all():
        return "a point has no value"
    fitted = fit(measured, form)
    if fitted.solution is None:
        return fitted.reason
    constants = ", ".join(f"{name} = {value:.3g}" for name, value in (fitted.in_millimetres() or {}).items())
    return f"{constants} ({1e3 * fitted.rms:.2f})"


def _speed_pictures(cubes: Cubes) -> Iterator[Picture]:
    for name in WITHIN:
        words = name.replace("_", " ").capitalize()
        title = f"{words}, copper cylinder on copper"
        yield against(f"table-3-4-{name}", title, cubes["craters"], name, "speed", _numbers())


CASE = (
    ValidationCase(
        name="table-3-3",
        says="the crater of a copper sphere of 0.5 g at 6 km/s: on cells of 1 mm within 15 % of the experiment, beside "
        "five other codes; contact raises the kinetic energy at no time; the energy that it takes, by cell and "
        "criterion",
        source="Ma (2005), section 3.2.1, Table 3.3 and Fig. 3.7; experiment of Wingate et al. (1993)",
        sweeps=_contact_sweeps,
        rows=_contact_rows,
        pictures=_contact_pictures,
    ),
    ValidationCase(
        name="table-3-4",
        says="craters of the thesis' copper cylinder at 4 to 7 km/s: on its cells of 1 mm within 2 mm in depth and 3 "
        "mm in diameter (its half model misses the diameter of 5 km/s by 0.2 mm); the value without a mesh beside it, "
        "deeper and wider",
        source="Ma (2005), section 3.2.2, Table 3.4: computed with MPM3D",
        sweeps=_speed_sweeps,
        rows=_speed_rows,
        pictures=_speed_pictures,
    ),
)
