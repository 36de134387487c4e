"""The command line: exit status, words, and that no mistake of a user ends in a traceback."""

import io
import json
import re
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from service.cli import local
from service.cli import validation as validation_commands
from service.cli.commands import computing
from service.cli.console import SHORT_ID, print_table
from service.records.jobs import RUN_STATES, Keep, SweepState, SweepStatus
from service.records.settings import Settings
from studies import examples, verification
from studies.values.recipes import ACCURACY
from tests.service.support.api import FILES, Api, open_api, served
from tests.service.support.command import run

Run = Callable[..., int]


@pytest.fixture
def whipple() -> Run:
    """Run the command in this process; gives its exit status."""
    return run


@pytest.fixture
def smoke(tmp_path: Path) -> Path:
    file = tmp_path / "smoke.yaml"
    file.write_text(examples.text("smoke"))
    return file


@pytest.fixture(scope="module")
def api(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Api]:
    with open_api(tmp_path_factory.mktemp("cli")) as opened:
        yield opened


@pytest.fixture(scope="module")
def url(api: Api) -> Iterator[str]:
    with served(api) as address:
        yield address


# --- without a service ------------------------------------------------------------------------------


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
    whipple: Run, tmp_path: Path, capsys: pytest.CaptureFixture[str], text: str, texts: list[str]
) -> None:
    file = tmp_path / "sweep.yaml"
    file.write_text(text)
    assert whipple("sweep", file, "--out", tmp_path / "out") == 2
    output = capsys.readouterr().err
    assert "Traceback" not in output
    for word in ("value", "limit", "cure", *texts):
        assert word in output


def test_estimate__prints_the_cost_and_that_of_each_accuracy(
    whipple: Run, smoke: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert whipple("estimate", smoke) == 0
    output = capsys.readouterr().out
    assert "smoke: 2 runs" in output
    for name, preset in ACCURACY.items():
        assert f"accuracy: {name}" in output
        assert f"{2 * len(preset.resolutions) * preset.offsets} runs" in output
        assert preset.meaning in output


@pytest.mark.parametrize("arguments", [["sweep"], ["nonsense"], ["serve", "--port", "x"], ["fetch"]])
def test_command__that_is_incomplete_ends_with_2(whipple: Run, arguments: list[str]) -> None:
    assert whipple(*arguments) == 2


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (["--host", "0.0.0.0", "--port", "0"], "keys create"),
        (["--port", "99999"], "port"),
        (["--port", "-1"], "port"),
        (["--engine", "tcp://127.0.0.1:8786"], "tls://"),
        (["--engine", "tls://127.0.0.1:8786"], "tls_ca"),
    ],
)
def test_serve__refuses_a_place_that_it_must_not_or_cannot_take(
    whipple: Run, tmp_path: Path, capsys: pytest.CaptureFixture[str], arguments: list[str], word: str
) -> None:
    assert whipple("serve", *arguments, "--data", tmp_path / "data") == 2
    assert word in capsys.readouterr().err


ROW = {
    "id": "0" * 32,
    "name": "smoke",
    "title": "smoke",
    "scenario": "thin_plate",
    "owner": "",
    "priority": 0,
    "keep": Keep.FINAL,
    "state": SweepState.SUCCEEDED,
    "reason": None,
    "planned": 2,
    "reused": 0,
    "new": 2,
    "lost_answers": 0,
    "progress": 1.0,
    "eta_seconds": None,
    "created": None,
    "cancelled": None,
    "finished": None,
}


def computed(**counts: int) -> Callable[..., local.Finished]:
    """An engine that has finished before it began."""
    row = SweepStatus(**{**ROW, "counts": dict.fromkeys(RUN_STATES, 0) | counts})  # type: ignore[arg-type]

    def run_sweep(
        document: Mapping[str, Any] | Path,
        out: Path,
        *,
        progress: Callable[[SweepStatus], None],
        settings: Settings,
        overwrite: bool,
        keep: str,
        ready: object,
    ) -> local.Finished:
        print(f"threads: {settings.threads}")
        progress(replace(row, progress=0.5, eta_seconds=61.0))
        progress(row)
        out.mkdir(exist_ok=True)
        report = {"verdict": {"summary": ["use the law", "rests on numerics"]}}
        (out / "report.json").write_text(json.dumps(report))
        return local.Finished(out, row)

    return run_sweep


@pytest.mark.parametrize(
    ("counts", "status"), [({"succeeded": 2}, 0), ({"succeeded": 1, "failed": 1}, 3), ({"cancelled": 2}, 3)]
)
def test_sweep__ends_with_0_if_all_succeeded_and_3_otherwise(
    whipple: Run,
    smoke: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    counts: dict[str, int],
    status: int,
) -> None:
    monkeypatch.setattr(local, "run_sweep", computed(**counts))
    assert whipple("sweep", smoke, "--out", tmp_path / "out") == status
    output = capsys.readouterr()
    assert "report.html" in output.out
    assert "  use the law\n  rests on numerics\n" in output.out
    for state, count in counts.items():
        assert f"{count} {state}" in output.out


@pytest.mark.parametrize(("word", "threads"), [("2", 2), ("auto", None)])
def test_sweep__takes_the_threads_that_it_is_given_and_not_those_of_the_environment(
    whipple: Run,
    smoke: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    word: str,
    threads: int | None,
) -> None:
    monkeypatch.setenv("WHIPPLE_THREADS", "7")
    monkeypatch.setattr(local, "run_sweep", computed(succeeded=2))
    whipple("sweep", smoke, "--out", tmp_path / "out", "--threads", word)
    assert f"threads: {threads}\n" in capsys.readouterr().out


def test_sweep__that_cannot_be_published_ends_with_1_and_the_reason(
    whipple: Run, smoke: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def fail(*_: object, **__: object) -> None:
        raise local.PublicationFailed("no space left on device")

    monkeypatch.setattr(local, "run_sweep", fail)
    assert whipple("sweep", smoke, "--out", tmp_path / "out") == 1
    assert capsys.readouterr().err == "whipple: no space left on device\n"


def test_warm__that_fails_says_why(
    whipple: Run, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(computing, "KERNELS", ("-c", "raise SystemExit('no compiler')"))
    assert whipple("warm") == 1
    assert "no compiler" in capsys.readouterr().err


def verified(monkeypatch: pytest.MonkeyPatch, *figures: float) -> None:
    """Let a verification case give these figures where 1 within 0.5 is expected."""
    rows = [verification.relative("pressure (GPa)", expected=1.0, got=figure, within=0.5) for figure in figures]
    answers = [verification.Verified("similarity", row, 0.1) for row in rows]
    monkeypatch.setattr(validation_commands, "verify", lambda _names: answers)


@pytest.mark.parametrize(("figures", "status"), [((1.0, 1.1), 0), ((1.0, 1.6), 1)])
def test_validate__of_a_case_prints_its_rows_and_writes_its_page(
    whipple: Run,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    figures: tuple[float, ...],
    status: int,
) -> None:
    verified(monkeypatch, *figures)
    assert whipple("validate", "similarity", "--out", tmp_path) == status
    *lines, counts, pages = capsys.readouterr().out.splitlines()
    assert [line.split(" | ")[0] for line in lines] == ["similarity"] * 2
    assert counts == f"{2 - status} passed, {status} failed, 0 reported"
    assert pages == f"pages: {tmp_path / 'index.html'}"
    assert counts in (tmp_path / "index.html").read_text()
    assert f"got {figures[1]:g}" in lines[1]
    cells = re.findall(r"<td[^>]*>([^<]*)</td>", (tmp_path / "similarity.html").read_text())
    assert f"{figures[1]:g}" in cells


def test_validate__refuses_what_it_does_not_have(
    whipple: Run, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert whipple("validate", "table-3-5", "--out", tmp_path) == 2
    assert "did you mean 'table-3-" in capsys.readouterr().err
    assert whipple("validate", "--level", "best", "--out", tmp_path) == 2
    assert "quick, thesis, fine" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("kind", "name", "words"),
    [
        ("materials", "copper-ofhc", ["8930 kg m-3", "Steinberg (1996)", "strength.A", "90 MPa"]),
        ("laws", "maiden_c", ["2.40 (v/C) (t/d)^(2/3)", "v <= 8 km/s"]),
        ("scenarios", "thin_plate", ["from 100 m/s to 20 km/s", "required", "hole_diameter"]),
    ],
)
def test_catalogue__is_that_of_the_api_in_tables_with_units(
    whipple: Run, api: Api, capsys: pytest.CaptureFixture[str], kind: str, name: str, words: list[str]
) -> None:
    items = api.http.get(f"/v1/{kind}").json()["items"]
    assert whipple(kind, "--json") == 0
    assert json.loads(capsys.readouterr().out) == items
    assert whipple(kind) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines[1:]] == [item["name"] for item in items]
    assert whipple(kind, name) == 0
    table = capsys.readouterr().out
    assert all(word in table for word in words), table
    assert whipple(kind, f"{name}x") == 2
    assert f"did you mean '{name}'" in capsys.readouterr().err


@pytest.mark.parametrize("option", ["-h", "--help", "--version"])
def test_option__that_every_command_line_has_is_there(
    whipple: Run, capsys: pytest.CaptureFixture[str], option: str
) -> None:
    assert whipple(option) == 0
    output = capsys.readouterr().out
    assert ("Requests to a service" in output) is (option != "--version")


def test_sweep__of_a_missing_file_names_the_one_beside_it_and_the_examples(
    whipple: Run, smoke: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    missing = smoke.with_name("smok.yaml")
    assert whipple("sweep", missing, "--out", tmp_path / "out") == 2
    output = capsys.readouterr().err
    for words in (f"{missing}: no such file", "did you mean 'smoke.yaml'", "holes.yaml"):
        assert words in output


def test_plot__of_a_missing_file_says_so_with_an_example(
    whipple: Run, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert whipple("plot", tmp_path / "nothere") == 2
    output = capsys.readouterr().err
    assert "nothere: no such file" in output
    assert "the cube.nc of a sweep" in output
    assert "Examples" not in output


def test_tables__cut_no_name_on_a_narrow_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    class Terminal(io.StringIO):
        def isatty(self) -> bool:
            return True

    monkeypatch.setenv("COLUMNS", "50")
    name, terminal = "al-6061-t6-steinberg-guinan", Terminal()
    print_table(("name", "title"), [(name, "Aluminium 6061-T6 " * 5)], file=terminal)
    assert name in terminal.getvalue()


def test_laws__are_listed_with_use(whipple: Run, capsys: pytest.CaptureFixture[str]) -> None:
    assert whipple("laws") == 0
    header, *lines = capsys.readouterr().out.splitlines()
    assert header.split() == ["name", "title", "quantity", "use"]
    (maiden,) = [line for line in lines if line.startswith("maiden_c ")]
    (carey,) = [line for line in lines if line.startswith("carey")]
    assert ("verdict" in maiden, "drawn only" in carey) == (True, True)


def test_estimate__warns_of_what_is_allowed_and_hardly_useful(
    whipple: Run, smoke: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert whipple("estimate", smoke) == 0
    assert "warning" not in capsys.readouterr().err
    smoke.write_text(smoke.read_text().replace("3 km/s", "0.1 km/s"))
    assert whipple("estimate", smoke, "--json") == 0
    output = capsys.readouterr()
    assert "warning: speed 100 m/s: rho v^2/Y" in output.err
    assert json.loads(output.out)["runs"] == 2


# --- with a service ---------------------------------------------------------------------------------


def test_submit_status_fetch__bring_a_sweep_home(
    whipple: Run, api: Api, url: str, smoke: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert whipple("submit", smoke, "--url", url) == 0
    id = capsys.readouterr().out.split()[0]
    api.compute()
    assert whipple("status", id, "--url", url) == 0
    assert "succeeded, 100% (2 succeeded)" in capsys.readouterr().out
    assert whipple("status", "--url", url) == 0
    assert id[:SHORT_ID] in capsys.readouterr().out
    assert whipple("fetch", id[:4], "--out", tmp_path / "out", "--url", url) == 0
    assert {file.name for file in (tmp_path / "out").iterdir()} == set(FILES)


def test_status__of_an_unknown_sweep_ends_with_1_and_one_sentence(
    whipple: Run, url: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert whipple("status", "nope", "--url", url) == 1
    output = capsys.readouterr().err
    assert output.startswith("whipple: ")
    assert output.count("\n") == 1
