"""The commands that ask a service: orders, what they print, and the key that goes with them."""

import json
import re
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from service.cli.console import SHORT_ID, print_table, say
from service.client.client import KEY_VARIABLE
from service.records.jobs import Scope
from studies.sweeps import examples
from tests.service.support.api import FILES, Api, open_api, served
from tests.service.support.command import run
from tests.service.support.fakes import wait_until

Capsys = pytest.CaptureFixture[str]
DEADLINE = 60.0


@pytest.fixture(autouse=True)
def _environment(monkeypatch: pytest.MonkeyPatch, url: str) -> None:
    monkeypatch.setenv("WHIPPLE_SERVICE", url)
    monkeypatch.delenv(KEY_VARIABLE, raising=False)


def submitted(capsys: Capsys, file: Path, *arguments: object) -> str:
    """The id of a sweep that the command submitted."""
    assert run("submit", file, *arguments) == 0
    return capsys.readouterr().out.split()[0]


@pytest.mark.parametrize(("failures", "status"), [(0, 0), (1, 3)])
def test_submit__waits_if_it_shall_and_ends_as_the_sweep_does(
    shared_api: Api, tmp_path: Path, capsys: Capsys, failures: int, status: int
) -> None:
    speed = f"4.{1 + failures} km/s"
    file = tmp_path / "sweep.yaml"
    file.write_text(examples.text("smoke").replace("3 km/s", speed))
    ended: list[int] = []
    waiting = threading.Thread(target=lambda: ended.append(run("submit", file, "--wait")))
    before = len(shared_api.store.sweeps.page().items)
    waiting.start()
    wait_until(lambda: len(shared_api.store.sweeps.page().items) > before)
    shared_api.compute(failures=failures)
    waiting.join(DEADLINE)
    assert ended == [status]
    assert "succeeded, 100%" in capsys.readouterr().out


def test_status__watches_what_happens_until_the_end(shared_api: Api, smoke: Path, capsys: Capsys) -> None:
    smoke.write_text(smoke.read_text().replace("3 km/s", "4.9 km/s"))  # a run of its own
    id = submitted(capsys, smoke)
    ended: list[int] = []
    watching = threading.Thread(target=lambda: ended.append(run("status", id, "--watch")))
    watching.start()
    streams = shared_api.http.app.state.event_streams  # type: ignore[attr-defined]
    wait_until(lambda: streams.opened.total() > 0)
    shared_api.compute()
    watching.join(DEADLINE)
    output = capsys.readouterr().out
    assert ended == [0]
    for word in ("accepted", "planned=2", "published", "succeeded, 100%"):
        assert word in output
    runs = {point.run.id for point in shared_api.store.sweeps.points(id).items}
    ids = set(re.findall(r"\b[0-9a-f]{12,}\b", output))
    assert ids <= runs | {id}
    assert id in ids
    assert runs & ids


def test_runs__are_told_with_values_as_a_sweep_has_them(shared_api: Api, tmp_path: Path, capsys: Capsys) -> None:
    file = tmp_path / "sweep.yaml"
    text = examples.text("smoke") + "offsets: 2\n"
    file.write_text(text.replace("axes:", "axes:\n  target.strength.A: [90 MPa]"))
    assert run("status", submitted(capsys, file), "--runs") == 0
    output = capsys.readouterr().out
    heading, *rows = output.splitlines()
    assert re.split(r"\s{2,}", heading)[3:6] == ["target.strength.A (GPa)", "speed (km/s)", "offset"]
    assert ["0.09", "6", "0.5"] in [row.split()[3:6] for row in rows]


def test_id__may_be_its_beginning_unless_several_have_it(shared_api: Api, capsys: Capsys) -> None:
    ids = [shared_api.submit(name=f"sweep {number}") for number in range(17)]
    twice = next(a[0] for a in ids if sum(b[0] == a[0] for b in ids) > 1)
    assert run("status", twice) == 2  # of 17 ids two begin alike
    output = capsys.readouterr().err
    assert "beginning of one id" in output
    assert all(id[:16] in output for id in ids if id.startswith(twice))
    run_id = shared_api.store.sweeps.points(ids[0]).items[0].run.id
    assert run("fetch", run_id[:20], "--log") == 1
    assert run_id in capsys.readouterr().err

    def printed(*arguments: str) -> Any:
        assert run(*arguments, "--json") == 0
        return json.loads(capsys.readouterr().out)

    assert printed("status", ids[0][:20])["id"] == ids[0]
    assert printed("status", ids[0][:20], "--runs")[0]["run"]["id"] == run_id
    assert {each["id"] for each in printed("status")} >= set(ids)
    assert printed("queue")["paused"] is None


@pytest.mark.parametrize(
    "arguments",
    [
        ("status", "1", "--watch", "--runs"),
        ("status", "1", "--watch", "--state", "failed"),
        ("fetch", "1", "--run", "--zip", "--out", "."),
        ("fetch", "1", "--log", "--zip"),
        ("doctor", "--adopt", "--json"),
    ],
)
def test_options__of_which_one_would_be_ignored_are_refused(arguments: tuple[str, ...], capsys: Capsys) -> None:
    assert run(*arguments) == 2
    assert re.search("cure +leave", capsys.readouterr().err)


def test_orders__move_a_sweep(shared_api: Api, tmp_path: Path, capsys: Capsys) -> None:
    file = tmp_path / "sweep.yaml"
    file.write_text(examples.text("smoke").replace("3 km/s", "6.5 km/s"))
    id = submitted(capsys, file, "--priority", "-3", "--keep", "numbers")
    sweeps = shared_api.store.sweeps
    assert (sweeps.get(id).priority, sweeps.get(id).keep, sweeps.get(id).owner) == (-3, "numbers", "")
    assert run("change", id, "--priority", "-5") == 0
    assert sweeps.get(id).priority == -5
    assert run("change", id) == 2
    assert run("change", id, "--priority", "1000") == 2
    assert "priority" in capsys.readouterr().err
    assert run("cancel", id) == 0
    assert "cancelled" in capsys.readouterr().out
    assert run("retry", id) == 0
    assert sweeps.get(id).counts["queued"] >= 1
    shared_api.compute()
    assert run("change", id, "--pin") == 0
    assert run("delete", id) == 1
    assert run("change", id, "--unpin") == 0
    assert run("delete", id) == 0
    assert "), pinned" in capsys.readouterr().out
    assert run("status", id) == 1
    output = capsys.readouterr().err
    assert output.startswith("whipple: ")
    assert output.count("\n") == 1


def test_queue__is_paused_and_resumed(shared_api: Api, capsys: Capsys) -> None:
    assert run("queue", "--pause") == 0
    assert "paused since" in capsys.readouterr().out
    assert shared_api.store.queue.status().paused
    assert run("queue", "--resume") == 0
    assert run("queue") == 0
    assert capsys.readouterr().out.count("open: ") == 2
    assert not shared_api.store.queue.status().paused


def test_results__come_home(shared_api: Api, smoke: Path, tmp_path: Path, capsys: Capsys) -> None:
    id = submitted(capsys, smoke)
    shared_api.compute()
    assert run("status", id) == 0
    assert "succeeded, 100% (2 succeeded)" in capsys.readouterr().out
    assert run("status") == 0
    assert id[:SHORT_ID] in capsys.readouterr().out
    assert run("fetch", id[:8], "--out", tmp_path / "new" / "folder") == 0
    assert {file.name: file.read_bytes() for file in (tmp_path / "new" / "folder").iterdir()} == FILES
    run_id = shared_api.store.sweeps.points(id).items[0].run.id
    assert run("fetch", run_id, "--run", "--out", tmp_path / "run") == 0
    assert (tmp_path / "run" / "result.json").read_bytes() == b"{}"
    assert run("fetch", run_id, "--log") == 1  # this engine writes none
    assert "Not found" in capsys.readouterr().err


@pytest.fixture
def elsewhere(tmp_path: Path) -> Iterator[tuple[str, str]]:
    """A service that asks everybody for a key: its address, and a key."""
    with open_api(tmp_path / "data") as api:
        settings = api.settings.model_copy(update={"host": "0.0.0.0"})
        api.http.app.state.settings = settings  # type: ignore[attr-defined]
        _, secret = api.store.keys.issue("anna", [Scope.SUBMIT])
        with served(api) as url:
            yield url, secret


def test_key__comes_from_a_file_or_the_environment(
    elsewhere: tuple[str, str], smoke: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capsys
) -> None:
    url, secret = elsewhere
    file = tmp_path / "key"
    file.write_text(f"{secret}\n")
    assert run("submit", smoke, "--url", url) == 1
    assert "Authorization" in capsys.readouterr().err
    assert run("submit", smoke, "--url", url, "--key-file", file) == 0
    monkeypatch.setenv(KEY_VARIABLE, secret)
    assert run("status", "--url", url) == 0
    assert run("queue", "--pause", "--url", url) == 1  # it is no admin's
    output = capsys.readouterr()
    assert "admin" in output.err
    assert secret not in output.out + output.err


@pytest.mark.parametrize("content", [b"", b"two words", b"\xff\xfe", None])
def test_key_file__that_is_none_ends_with_2_and_is_not_shown(
    url: str, tmp_path: Path, capsys: Capsys, content: bytes | None
) -> None:
    file = tmp_path / "key"
    if content is not None:
        file.write_bytes(content)
    assert run("status", "--url", url, "--key-file", file) == 2
    output = capsys.readouterr().err
    assert "whipple keys create" in output or "correct the path" in output
    assert "two words" not in output


def test_texts__of_other_users_do_not_command_the_terminal(capsys: Capsys) -> None:
    """Sweeps from before names were checked, and whatever a service says."""
    say("\x1b]0;title\x07 a\rb\u202ec\x9b2J")
    print_table(("id", "name"), [("1", "\x1b[31mred")])
    output = capsys.readouterr().out
    assert all(part.isprintable() for part in output.splitlines())
    assert output.startswith(r"\u001b]0;title\u0007 a\rb\u202ec\u009b2J")
    assert r"\u001b[31mred" in output
