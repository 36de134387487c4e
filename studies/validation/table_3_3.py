"""The crater of a copper sphere of 0.5 g at 6 km/s, by criterion of contact: Ma (2005), section 3.2.1, Table 3.3.

The thesis' contact raised the kinetic energy at the first touch (Fig. 3.7) and made the crater larger; energy that
contact takes or gives is an error of the discretisation, and falls with the cell. Its printed criterion stands beside
ours.
"""

import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from studies.validation import Cubes, Level, Picture, Validation, published
from studies.validation._block import CELL, MESH, craters
from studies.validation._compare import ComparedReading, compared, energy_line, grids_of, kinetic_energy
from studies.values.quantities import round_quantity
from studies.verification import Row, at_most, reported

# 0.5 g of copper of 8930 kg/m3: Ma (2005), Table 3.2.
DIAMETER = round_quantity((6.0 * 0.5e-3 / (math.pi * 8930.0)) ** (1.0 / 3.0))  # m
CELLS = round_quantity(DIAMETER / CELL)

# Of the experiment, as the project's reference asks of craters against experiments; the figures on cells of 1 mm were
# known when this was written: 15 mm and 25 mm.
SHARE = 0.15
RISE = 1e-9  # of the kinetic energy, over the initial one: round-off of its sum
CONTACTS = {"none": "no contact", "bardenhagen": "contact", "thesis": "contact by the printed criterion"}


def _sweeps(level: Level) -> Mapping[str, Mapping[str, Any]]:
    crater = craters(level, DIAMETER, "32 us", speed="6 km/s")
    title = "Crater of a copper sphere of 0.5 g at 6 km/s: Ma (2005), Table 3.3"
    contacts = list(CONTACTS)[:2] if level == "quick" else list(CONTACTS)
    return {"contact": {"title": title, "axes": {"contact": contacts}, **crater}}


def _rows(level: Level, cubes: Cubes) -> Iterator[Row]:
    cube, numbers = cubes["contact"], published("table_3_3", "thick_plate")
    contacts = {str(contact): CONTACTS[str(contact)] for contact in cube.contact.values}
    for contact, words in contacts.items():
        for name in ("crater_depth", "crater_diameter"):
            quantity = ComparedReading(cube, name, {"contact": contact})
            share = SHARE if contact == "none" else None
            yield from compared(words, quantity, numbers, "experiment", mesh=(CELLS, MESH), share=share)
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


def _runs(cubes: Cubes, contact: str) -> Iterator[tuple[str, Any]]:
    """The runs with or without contact, coarse to fine, with the size of their cells in words."""
    for cells, run in grids_of(cubes["contact"].sel(contact=contact)):
        yield f"cells of {1e3 * DIAMETER / cells:.3g} mm", run


def _pictures(cubes: Cubes) -> Iterator[Picture]:
    lines = [
        energy_line(f"{words}, {cells}", run)
        for contact, words in CONTACTS.items()
        if contact in cubes["contact"].contact.values
        for cells, run in _runs(cubes, contact)
    ]
    title = "Kinetic energy with and without contact (Fig. 3.7)"
    yield Picture("table-3-3-energy", title, "time (µs)", "kinetic energy (J)", tuple(lines))


CASE = Validation(
    name="table-3-3",
    says="the crater of a copper sphere of 0.5 g at 6 km/s: on cells of 1 mm within 15 % of the experiment, beside "
    "five other codes; contact raises the kinetic energy at no time; the energy that it takes, by cell and criterion",
    source="Ma (2005), section 3.2.1, Table 3.3 and Fig. 3.7; experiment of Wingate et al. (1993)",
    sweeps=_sweeps,
    rows=_rows,
    pictures=_pictures,
)
