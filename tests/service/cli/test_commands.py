"""The command line: exit status, words, and that no mistake of a user ends in a traceback."""

import json
import re
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from service.cli import local
from service.records.jobs import SweepStatus
from service.settings import Settings
from studies.convergence import experience
from studies.sweeps.accuracy import ACCURACY, in_percent
from tests.service.support.api import FILES, Api
from tests.service.support.command import run
from tests.studies.convergence.test_experience import KNOWN

Capsys = pytest.CaptureFixture[str]


def test_help__loads_nothing_heavy() -> None:
    code = """
import sys
from service.cli import main as cli
sys.argv = ["whipple", "--help"]
try:
    cli.main()
except SystemExit:
    pass
heavy = {"numba", "xarray", "numpy", "fastapi", "sqlalchemy", "distributed", "httpx"}
assert not heavy & set(sys.modules), heavy & set(sys.modules)
"""
    subprocess.run([sys.executable, "-c", code], check=True, capture_output=True)


@pytest.mark.claim("bad-input", "bad-input-command")
@pytest.mark.parametrize(
    ("text", "texts"),
    [
        ("scenario: thin_plat\naxes: {speed: [6 km/s]}", ["scenario", "did you mean 'thin_plate'"]),
        ("scenario: thin_plate\naxes: {speed: [6]}", ["axes.speed[0]", "6 km/s"]),
        ("a: [1,\nb: }", ["line 2"]),
        ("just words", ["mapping"]),
        ("", ["mapping"]),
        ("\x00", []),
    ],
)
def test_sweep__of_bad_input_ends_with_2_and_the_cure(
    tmp_path: Path, capsys: Capsys, text: str, texts: list[str]
) -> None:
    """Bad input on the command line is exit 2 with field, value, limit and cure."""
    file = tmp_path / "sweep.yaml"
    file.write_text(text)
    assert run("sweep", file, "--out", tmp_path / "out") == 2
    output = capsys.readouterr().err
    assert "Traceback" not in output
    for word in ("value", "limit", "cure", *texts):
        assert word in output


def test_estimate__prints_the_cost_at_each_accuracy_and_warnings(
    smoke: Path, capsys: Capsys, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(experience, "stored", dict)
    assert run("estimate", smoke) == 0
    output = capsys.readouterr()
    assert "smoke: 2 runs" in output.out
    assert "warning" not in output.err
    for name, error in ACCURACY.items():
        assert f"accuracy: {in_percent(error)} ({name})" in output.out
    assert "not available: a resolution, since the mesh error is unknown" in output.out
    monkeypatch.setattr(experience, "stored", lambda: KNOWN)
    assert run("estimate", smoke, "--accuracy", "4%") == 0
    output = capsys.readouterr()
    assert re.search(r"accuracy: 2 % \(fine\) +\d+ cells across the diameter: 2 runs, about", output.out)
    smoke.write_text(smoke.read_text().replace("3 km/s", "0.1 km/s"))
    assert run("estimate", smoke, "--json") == 0
    output = capsys.readouterr()
    assert "warning: speed 100 m/s: rho v^2/Y" in output.err
    assert json.loads(output.out)["runs"] == 2


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (["--host", "0.0.0.0", "--port", "0"], "keys create"),
        (["--port", "99999"], "port"),
        (["--port", "-1"], "port"),
        (["--engine", "dask://127.0.0.1:8786"], "no engine serves dask://"),
        (["--engine", "tls://127.0.0.1:8786"], "tls_ca"),
    ],
)
def test_serve__refuses_a_place_that_it_must_not_or_cannot_take(
    tmp_path: Path, capsys: Capsys, arguments: list[str], word: str
) -> None:
    assert run("serve", *arguments, "--data", tmp_path / "data") == 2
    assert word in capsys.readouterr().err


def finished(status: SweepStatus) -> Callable[..., local.Finished]:
    """In place of an engine: a sweep that has ended before it began."""

    def run_sweep(_document: object, out: Path, *, progress: Any, settings: Settings, **_: object) -> local.Finished:
        print(f"threads: {settings.threads}")
        progress(replace(status, progress=0.5, eta_seconds=61.0))
        progress(status)
        out.mkdir(exist_ok=True)
        (out / "report.json").write_bytes(FILES["report.json"])
        return local.Finished(out, status)

    return run_sweep


@pytest.mark.parametrize(("end", "status"), [("2 succeeded", 0), ("1 succeeded, 1 failed", 3), ("2 cancelled", 3)])
def test_sweep__ends_with_0_if_all_succeeded_and_3_otherwise(
    api: Api, smoke: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capsys, end: str, status: int
) -> None:
    id = api.submit()
    if "cancelled" in end:
        api.store.sweeps.cancel(id)
    api.compute(failures=end.count("failed"))
    monkeypatch.setattr(local, "run_sweep", finished(api.store.sweeps.get(id)))
    monkeypatch.setenv("WHIPPLE_THREADS", "7")
    for option, threads in (("2", 2), ("auto", None)):  # not those of the environment
        assert run("sweep", smoke, "--out", tmp_path / "out", "--threads", option) == status
        output = capsys.readouterr().out
        assert f"threads: {threads}\n" in output
        assert "report.html" in output
        assert "\n  Use the law; simulation only.\n" in output
        assert end in output
