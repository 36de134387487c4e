"""What can be set: defaults, and words for what is refused."""

from pathlib import Path
from typing import Any

import pytest
from pydantic import ByteSize, ValidationError

from service import settings as module
from service.settings import Settings

GIBIBYTE = 1 << 30


@pytest.fixture
def certificates(tmp_path: Path) -> dict[str, Any]:
    files = {name: tmp_path / f"{name}.pem" for name in ("tls_ca", "tls_cert", "tls_key")}
    for file in files.values():
        file.touch()
    return {**files, "memory_limit": GIBIBYTE}


def refusals(**given: Any) -> dict[str, str]:
    """What is refused, and what would be allowed."""
    with pytest.raises(ValidationError) as refused:
        Settings(**given)
    return {str(one["loc"][0]): one["msg"] for one in refused.value.errors()}


def test_memory__of_a_run_is_the_machines_divided_by_the_workers(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "_available_memory", lambda: 8 * GIBIBYTE)
    assert Settings(workers=4).memory_of_a_run == 2 * GIBIBYTE
    assert Settings(workers=4, memory_limit=ByteSize(GIBIBYTE)).memory_of_a_run == GIBIBYTE


def test_memory__a_container_may_have_less_than_the_machine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    limit = tmp_path / "memory.max"
    limit.write_text(f"{GIBIBYTE}\n")
    monkeypatch.setattr(module, "CONTROL_GROUP", limit)
    assert Settings(workers=2).memory_of_a_run == GIBIBYTE // 2
    limit.write_text("max\n")
    assert (Settings(workers=1).memory_of_a_run or 0) >= GIBIBYTE // 2


def test_memory__of_other_machines_has_to_be_said(certificates: dict[str, Any]) -> None:
    elsewhere = {"engine": "tls://scheduler.example.org:8786", **certificates}
    said = refusals(**{**elsewhere, "memory_limit": None})
    assert "the memory that one run may use on a worker" in said["memory_limit"]
    assert Settings(**elsewhere).memory_of_a_run == GIBIBYTE


@pytest.mark.parametrize("given", ["true", "", '"10.0.0.1"', "[true]"])
def test_proxy__is_named_by_its_addresses(monkeypatch: pytest.MonkeyPatch, given: str) -> None:
    monkeypatch.setenv("WHIPPLE_TRUSTED_PROXY", given)
    assert "a JSON list of the addresses" in refusals()["trusted_proxy"]


def test_proxies__are_addresses_and_networks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("WHIPPLE_TRUSTED_PROXY", '["127.0.0.1", "10.0.3.0/24", "fd00::/8"]')
    known = [str(one) for one in Settings().trusted_proxy]
    assert known == ["127.0.0.1/32", "10.0.3.0/24", "fd00::/8"]
    assert Settings(trusted_proxy=()).trusted_proxy == ()


@pytest.mark.parametrize("address", ["tls://a", "tls://:8786", "tls://a:x"])
def test_engine__only_with_a_port(address: str, certificates: dict[str, Any]) -> None:
    said = refusals(engine=address, **certificates)
    assert said == {"engine": "an address such as tls://scheduler.example.org:8786"}


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"engine": "tcp://a:8786"}, "no engine serves tcp://; there are: tls://"),
        ({"engine": ""}, "no engine serves ://"),
        (
            {"artifacts": "nonesuch://bucket"},
            "no store of files serves nonesuch://; there are: abfs://, abfss://, az://",
        ),
    ],
)
def test_address__of_a_scheme_that_nothing_serves_is_refused(given: dict[str, Any], says: str) -> None:
    [said] = refusals(**given).values()
    assert says in said


def test_engine__needs_its_certificates(certificates: dict[str, Any]) -> None:
    del certificates["tls_key"]
    said = refusals(engine="tls://a:8786", **certificates)
    assert said == {"tls_key": "a PEM file, which the engine at tls://a:8786 requires"}


@pytest.mark.parametrize(("word", "of_a_run"), [(None, 4), ("auto", 4), ("3", 3)])
def test_threads__are_those_that_are_asked_for_or_the_free_workers(
    monkeypatch: pytest.MonkeyPatch, word: str | None, of_a_run: int
) -> None:
    monkeypatch.delenv("WHIPPLE_THREADS", raising=False)
    if word is not None:
        monkeypatch.setenv("WHIPPLE_THREADS", word)
    assert Settings().threads_of_a_run(workers=8, runs=2) == of_a_run
    assert Settings(threads=None).threads_of_a_run(workers=8, runs=3) == 2
    assert Settings(threads=None).threads_of_a_run(workers=1, runs=4) == 1


def test_password__of_the_database_is_read_from_a_file(tmp_path: Path) -> None:
    file = tmp_path / "password"
    file.write_text("a:b@c/d\n")
    given = {"database_url": "postgresql+psycopg://whipple@database/whipple", "database_password_file": file}
    assert Settings.model_validate(given).url == "postgresql+psycopg://whipple:a%3Ab%40c%2Fd@database/whipple"
    assert Settings(database_password_file=file, data=tmp_path).url.startswith("sqlite:")
    for change, limit in (
        ({"database_url": "postgresql+psycopg://whipple:known@database/whipple"}, "without a password"),
        ({"database_url": "postgresql+psycopg://database/whipple"}, "without a password"),
        ({"database_password_file": tmp_path / "none"}, "a file that this user may read"),
    ):
        assert limit in refusals(**{**given, **change})["database_password_file"]
