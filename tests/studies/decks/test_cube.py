"""Decks in cubes and reports."""

import json
from collections.abc import Callable
from hashlib import sha256
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from studies.quantities.files import CUBE, REPORT_HTML, REPORT_JSON, RUNS_CSV
from studies.quantities.parameters import Plain
from studies.reports.publish import publish
from tests.claims.rows import Row, equal
from tests.studies.cubes.test_bodies import computed, reported, starts, table
from tests.studies.decks.texts import appendix_deck, soil_deck
from tests.studies.support.printed import undrawn


@pytest.mark.claim("mend-again", "sweep-over-decks", minutes=0.5)
def test_sweep_over_decks__is_the_hand_made_table(tmp_path: Path, compared: Callable[[Row], None]) -> None:
    """A sweep over decks with two bodies and one has the bodies of each run by name, in the cube and in the report."""
    two, one = appendix_deck(), soil_deck()
    dataset = computed({"scenario": "deck", "fixed": {"end_time": "1e-6 s"}, "axes": {"deck": [two, one]}}, tmp_path)
    first, second, none = two.splitlines()[0], one.splitlines()[0], np.nan
    # 129 of 130 particles of 8.9 g/cm3 and half a millimetre at 200 m/s, one at rest; 16.8 t of soil that
    # fall at 1 m/s.
    particle, soil = 8900.0 * 0.5e-3**3, 16800.0
    bodies = ("component_1", "component_2", "body_1")
    energies = (129 * 0.5 * particle * 200.0**2, 0.0, none), (none, none, 0.5 * soil)
    momenta = (129 * particle * 200.0, 0.0, none), (none, none, -soil)
    for kind, rows in (("kinetic_energy", energies), ("axial_momentum", momenta)):
        expected = {
            (run, body): value
            for run, row in zip((first, second), rows, strict=True)
            for body, value in zip(bodies, row, strict=True)
        }
        for row in table(expected, starts(dataset, kind)):
            compared(row)
    states = [run["state"] for run in reported(dataset)["runs"]["runs"]]
    compared(equal("states in the report", expected=["succeeded"] * 2, got=states))


def test_deck__stands_by_its_first_line_and_digest_and_the_cube_has_its_text(tmp_path: Path) -> None:
    texts = [appendix_deck().replace("tstep 400", f"tstep {steps}") for steps in (400, 401)]
    assert all("nbmp 260" in text for text in texts)
    document: dict[str, Plain] = {"name": "decks", "scenario": "deck", "axes": {"deck": texts}}
    with undrawn():
        files = publish(document, {}, tmp_path)
    lines = len(texts[0].splitlines())
    digests = [sha256(text.encode()).hexdigest()[:16] for text in texts]
    shorts = [f"({lines} lines, SHA-256 {digest})" for digest in digests]
    for name in (REPORT_JSON, REPORT_HTML, RUNS_CSV):
        written = Path(files[name]).read_text()
        assert all(f"mpm3d *** test my Code ! title {short}" in written for short in shorts), name
        assert "nbmp 260" not in written, name
    with xr.open_dataset(files[CUBE]) as dataset:
        assert dataset.deck.values.tolist() == texts
        assert json.loads(dataset.attrs["sweep"])["axes"]["deck"] == texts
