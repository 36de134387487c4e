"""A fit as a law of the next sweep: a document that is part of the sweep's, and changes no run."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from studies.cubes.catalogue import catalogue_of
from studies.cubes.cube import write
from studies.fits.fit import fit
from studies.fits.fitted import FittedLaw, read_law
from studies.fits.forms import FORMS
from studies.fits.measured import of_cube
from studies.quantities.findings import InvalidInput
from studies.sweeps.document import read_sweep_file
from studies.sweeps.sweep import Sweep
from tests.service.support.command import run
from tests.studies.support.sized import CRATERS, sized_cube


@pytest.fixture(scope="module")
def law() -> FittedLaw:
    dataset = sized_cube(CRATERS, lambda shot: 2e-4 * shot.speed**0.5, "crater_depth")
    return fit(of_cube(dataset, "crater_depth"), FORMS["power"]).law()


def test_law__is_in_the_sweep_and_its_cube_and_changes_no_run(law: FittedLaw) -> None:
    plain = Sweep.parse(CRATERS)
    sweep = Sweep.parse({**CRATERS, "laws": [law.document()]})
    assert Sweep.parse(sweep.document()) == sweep
    assert sweep.laws == (law,)
    assert [point.run.id for point in sweep.runs()] == [point.run.id for point in plain.runs()]
    catalogue = catalogue_of(sweep)
    shots = [catalogue.shot_of(point.run) for point in sweep.runs()]
    labels = [choice.label for choice in catalogue.choices("crater_depth", shots)]
    assert labels[-1] == "made-up-power"
    assert catalogue.laws[-1].title == "fit of made-up"


@pytest.mark.parametrize(
    ("change", "field"),
    [
        (lambda plain: plain.update(form="sine"), "laws[0].form"),
        (lambda plain: plain.update(law="charters_summers"), "laws[0].law"),
        (lambda plain: plain.update(quantity="hole_diameter"), "laws"),
        (lambda plain: plain["constants"].pop("n"), "laws[0].constants"),
        (lambda plain: plain["constants"]["n"].update(value="1"), "laws[0].constants.n.value"),
        (lambda plain: plain["range"].update(speed=["8 km/s", "3 km/s"]), "laws[0].range.speed"),
        (lambda plain: plain["range"].update(materials="copper"), "laws[0].range.materials"),
        (lambda plain: plain.update(colour="red"), "laws[0].colour"),
    ],
)
def test_law__that_is_wrong_is_refused_by_name(
    law: FittedLaw, change: Callable[[dict[str, Any]], object], field: str
) -> None:
    document = law.document()
    change(document)
    with pytest.raises(InvalidInput) as refused:
        Sweep.parse({**CRATERS, "laws": [document]})
    assert field in [finding.field for finding in refused.value.findings]


def test_file__of_a_fit_is_read_into_the_document_of_a_sweep(law: FittedLaw, tmp_path: Path) -> None:
    (tmp_path / "my.json").write_text(json.dumps(law.document()))
    sweep = tmp_path / "sweep.yaml"
    sweep.write_text(json.dumps({**CRATERS, "laws": ["my.json"]}))
    assert Sweep.parse(read_sweep_file(sweep)).laws == (law,)


def test_command__writes_a_fit_that_a_sweep_reads(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    dataset = sized_cube(CRATERS, lambda shot: 2e-4 * shot.speed**0.5, "crater_depth")
    write(dataset, tmp_path / "cube.nc")
    file = tmp_path / "my.json"
    options = ["--quantity", "crater_depth", "--form", "power", "--out", str(file)]
    assert run("fit", str(tmp_path), *options) == 0
    assert "n = 0.5 (0.5 to 0.5)" in capsys.readouterr().out
    assert read_law(json.loads(file.read_text()), "law").constants["n"].value == pytest.approx(0.5)
    for wrong in (["--form", "cubic"], ["--quantity", "depth"], ["--at", "x=1"], ["--out", str(file)]):
        assert run("fit", str(tmp_path), *wrong) == 2
    assert run("fit", str(file)) == 2
