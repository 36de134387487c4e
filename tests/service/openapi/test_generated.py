"""A client that openapi-python-client makes of the description: it submits a sweep, and its types know the fields."""

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from service.records.jobs import Scope
from tests.claims.rows import equal
from tests.service.support.fakes import issue_key
from tests.service.support.serving import serving

GENERATOR = "openapi-python-client==0.29.1"  # installed for this claim alone
PROGRAM = """
import sys

from client import AuthenticatedClient
from client.api.catalogue import evaluate_laws
from client.api.submit import submit_sweep
from client.models import (
    AcceptedSweepModel, Geometry, LawsAnswer, ShotQuestion, ThinPlateAxes, ThinPlateFixed, ThinPlateSweep
)

fixed = ThinPlateFixed(
    speed="6 km/s", geometry=Geometry.AXISYMMETRIC,
    projectile="copper-ofhc", target="copper-ofhc", projectile_diameter="8 mm",
)
fixed["target.strength.A"] = "100 MPa"
sweep = ThinPlateSweep(
    scenario="thin_plate", fixed=fixed, axes=ThinPlateAxes(plate_thickness=["2 mm", "3 mm"]), resolution=8
)
shot = ShotQuestion(speed="6 km/s", projectile="copper-ofhc", target="copper-ofhc", projectile_diameter="8 mm")
client = AuthenticatedClient(base_url=sys.argv[1], token=sys.argv[2])
accepted = submit_sweep.sync(client=client, body=sweep)
assert isinstance(accepted, AcceptedSweepModel), accepted
answer = evaluate_laws.sync(client=client, body=shot)
assert isinstance(answer, LawsAnswer), answer
print(accepted.planned, answer.target, answer.items[0].quantities[0].unit)
"""


@pytest.mark.claim("contract", "generated-client", minutes=2.0)
def test_generated_client__submits_a_sweep_and_its_types_refuse_a_misspelt_field(
    tmp_path: Path, compared: Callable[..., None]
) -> None:
    """A client that openapi-python-client makes submits a sweep; mypy takes its `speed=` and refuses `sped=`."""
    python = tmp_path / "venv" / "bin" / "python"
    for command in (
        [sys.executable, "-m", "venv", tmp_path / "venv"],
        [python, "-m", "pip", "install", "-q", GENERATOR],
    ):
        subprocess.run([*map(str, command)], check=True)
    (tmp_path / "data").mkdir()
    secret = issue_key(tmp_path / "data", "anna", Scope.SUBMIT)
    right, wrong = tmp_path / "right.py", tmp_path / "wrong.py"
    right.write_text(PROGRAM)
    wrong.write_text(PROGRAM.replace("(\n    speed=", "(\n    sped="))
    with serving(tmp_path / "data") as service:
        service.wait_until_ready()
        generate = ["generate", "--url", f"{service.url}/openapi.json", "--output-path", "client", "--meta", "none"]
        made = _run(tmp_path, str(python.with_name("openapi-python-client")), *generate)
        ran = _run(tmp_path, str(python), str(right), service.url, secret)
    compared(
        equal("parts that could not be generated", expected=0, got=made.count("Unable to ")),
        equal("runs, target of the laws and unit, as the client reads them", expected="2 block m", got=ran.strip()),
        equal("errors of mypy in the program", expected=[], got=_errors(tmp_path, python, right)),
        equal("errors of mypy with sped=", expected=["call-arg"], got=_errors(tmp_path, python, wrong)),
    )


def _run(folder: Path, *command: str) -> str:
    ended = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=300, check=False)
    assert ended.returncode == 0, ended.stdout[-2000:] + ended.stderr[-2000:]
    return ended.stdout


def _errors(folder: Path, python: Path, program: Path) -> list[str]:
    """The kinds of errors that mypy finds in a program."""
    command = [sys.executable, "-m", "mypy", "--python-executable", str(python), "--follow-imports", "silent", program]
    found = subprocess.run([*map(str, command)], cwd=folder, capture_output=True, text=True, check=False).stdout
    return [line.rpartition("[")[2].rstrip("]") for line in found.splitlines() if ": error: " in line]
