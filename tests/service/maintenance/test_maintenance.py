"""The commands that work on database and files: keys, doctor, and what they refuse."""

import json
import os
import pwd
import re
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest
import sqlalchemy as sa

from service.files.stores import IDENTITY
from service.queue import data_identity as identity
from service.records.clock import DAY, ClockHistory, read_clocks
from service.records.jobs import Scope, Submission
from service.settings import Settings
from service.store import Store
from service.store.tables import CONTROL
from tests.service.support.command import run
from tests.service.support.fakes import sweep_of
from tests.service.support.rows import finish_all

Capsys = pytest.CaptureFixture[str]


@pytest.fixture
def data(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A data directory that is not there yet, and which every command means."""
    monkeypatch.setenv("WHIPPLE_DATA", str(tmp_path / "data"))
    monkeypatch.delenv("WHIPPLE_DATABASE_URL", raising=False)
    return tmp_path / "data"


@pytest.fixture
def store(data: Path) -> Iterator[Store]:
    """A store in that directory."""
    data.mkdir()
    with closing(Store.open(Settings(data=data).url)) as opened:
        yield opened


def created(capsys: Capsys, *arguments: object) -> str:
    """The secret of a key that the command made."""
    assert run("keys", "create", *arguments) == 0
    return capsys.readouterr().out.strip()


def test_first_key__is_made_before_the_service_ever_ran(data: Path, capsys: Capsys) -> None:
    secret = created(capsys, "anna")
    with closing(Store.open(Settings(data=data).url)) as store:
        result = store.keys.find(secret)
        assert result is not None
        assert (result.name, result.expires) == ("anna", None)
        assert result.scopes == {Scope.SUBMIT}


def test_key__is_listed_without_its_secret_and_of_no_use_once_it_is_revoked(store: Store, capsys: Capsys) -> None:
    secret = created(capsys, "anna")
    assert run("keys", "list") == 0
    output = capsys.readouterr().out
    assert re.search(r"\.\.\.  anna  submit  +never  +never", output)
    assert secret not in output
    assert store.keys.all()[0].prefix in output
    other = created(capsys, "bert")
    assert run("keys", "revoke", store.keys.all()[0].id[:8]) == 0
    assert "revoked" in capsys.readouterr().out
    assert run("keys", "list", "--json") == 0
    assert json.loads(capsys.readouterr().out)[0]["scopes"] == ["submit"]
    assert store.keys.find(secret) is None
    assert store.keys.find(other) is not None


@pytest.mark.parametrize(
    "arguments",
    [
        ("create",),
        ("create", " "),
        ("create", "a\x07b"),
        ("create", "anna", "--scope", "root"),
        ("create", "anna", "--expires", "soon"),
        ("create", "anna", "--expires", "0d"),
        ("revoke", "nobody"),
    ],
)
@pytest.mark.usefixtures("store")
def test_keys__refuse_what_they_do_not_know(arguments: tuple[str, ...], capsys: Capsys) -> None:
    assert run("keys", *arguments) == 2
    assert "Traceback" not in capsys.readouterr().err


@pytest.mark.usefixtures("store")
def test_clock__is_trusted_by_a_command(store: Store, capsys: Capsys) -> None:
    now = read_clocks()
    jumped = ClockHistory(now).seen(now._replace(wall=now.wall + 45 * DAY)).with_pause(30 * DAY)
    store.retention.note_clock_history(lambda _: jumped)
    assert store.queue.status().deletion_paused
    assert run("doctor", "--trust-clock") == 0
    assert store.queue.status().deletion_paused is None
    assert "believed" in capsys.readouterr().out


@pytest.mark.claim("doors", "audit")
def test_orders_of_the_shell__are_recorded_as_the_local_users(store: Store, capsys: Capsys) -> None:
    """Commands that change the store are in the audit trail, which `whipple keys audit` prints, as the local user's."""
    created(capsys, "anna")
    assert run("keys", "rotate", "anna", "--grace", "12h") == 0
    successor = capsys.readouterr().out.strip()
    assert run("keys", "rotate", "anna") == 2  # two have the name
    assert run("keys", "revoke", successor[:12]) == 0
    assert run("keys", "revoke", "anna") == 0  # the other one
    capsys.readouterr()
    assert run("keys", "audit", "--json") == 0
    entries = json.loads(capsys.readouterr().out)
    old, new = (key.id for key in store.keys.all())
    orders = [("key created", old), ("key rotated", old), ("key revoked", new), ("key revoked", old)]
    assert [(entry["action"], entry["subject"]) for entry in entries] == orders
    user = pwd.getpwuid(os.getuid()).pw_name
    assert {(entry["owner"], entry["address"]) for entry in entries} == {(user, f"uid {os.getuid()}")}
    for word, count in ((f"owner={user}", 4), ("action=key revoked", 2), ("owner=bert", 0), ("since=2999-01-01", 0)):
        assert run("keys", "audit", f"--{word}") == 0
        assert len(capsys.readouterr().out.splitlines()) == 1 + count, word


@pytest.mark.parametrize(
    "arguments", [("keys", "list"), ("keys", "audit"), ("doctor", "--remeasure"), ("backup", "out")]
)
def test_command__without_a_database_says_how_to_name_one(
    data: Path, arguments: tuple[str, ...], capsys: Capsys
) -> None:
    assert run(*arguments) == 1
    assert "WHIPPLE_DATA" in capsys.readouterr().err
    assert not data.exists()


def test_retention__lists_what_it_would_delete_and_deletes_it_on_request(store: Store, capsys: Capsys) -> None:
    ids = [store.sweeps.create(Submission(sweep_of(1), owner=owner)).id for owner in ("anna", "bert")]
    finish_all(store)
    assert run("retention", "--older-than", "1d", "--json") == 0
    assert json.loads(capsys.readouterr().out) == []
    assert run("retention", "--to-size", "0MB") == 0
    output = capsys.readouterr()
    assert all(id[:12] in output.out for id in ids)
    assert ("2 sweeps, 0.0 MB" in output.out, "--apply" in output.err) == (True, True)
    assert run("retention", "--owner", "anna", "--apply") == 0
    assert [sweep.id for sweep in store.sweeps.page().items] == ids[1:]


@pytest.mark.parametrize("arguments", [(), ("--older-than", "old"), ("--to-size", "much"), ("--to-size", "-1")])
@pytest.mark.usefixtures("store")
def test_retention__needs_a_rule(arguments: tuple[str, ...], capsys: Capsys) -> None:
    assert run("retention", *arguments, "--apply") == 2
    assert "cure" in capsys.readouterr().err


def test_adopt__lets_an_empty_directory_belong_to_the_database(data: Path, store: Store, capsys: Capsys) -> None:
    identity.settle(Settings(data=data), store)
    (data / IDENTITY).unlink()
    assert run("doctor") == 1
    assert "has no id" in capsys.readouterr().out
    assert run("doctor", "--adopt") == 0
    assert str(store.data_id()) in capsys.readouterr().out
    assert identity.read(data) == store.data_id()


def test_forget_lost__allows_so_many(store: Store, capsys: Capsys) -> None:
    assert run("doctor", "--forget-lost", "12") == 0
    assert "12 lost results may be computed again" in capsys.readouterr().out
    with store.database.reading() as reading:
        assert reading.execute(sa.select(CONTROL.c.forgettable)).scalar() == 12
