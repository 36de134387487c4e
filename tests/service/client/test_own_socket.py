"""The door of the data directory's owner, where the loopback asks for a key."""

import os
import stat
from pathlib import Path

import httpx
import pytest

from service.cli.serve import _door_of_the_user
from service.client.client import DEFAULT_URL, Client
from service.client.commands import client_of
from service.files import SOCKET
from service.settings import Settings
from studies.quantities.findings import InvalidInput
from tests.claims.marked import Compared
from tests.claims.rows import equal
from tests.service.support.api import SWEEP, open_api, served
from tests.service.support.command import run


@pytest.mark.claim("doors", "own-socket")
def test_socket__serves_the_command_line_where_the_loopback_asks_for_a_key(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, compared: Compared
) -> None:
    """With WHIPPLE_TRUST_LOOPBACK=false the loopback asks for a key, and the owner's command line needs none."""
    monkeypatch.delenv("WHIPPLE_SERVICE", raising=False)
    monkeypatch.setenv("WHIPPLE_DATA", str(tmp_path))
    with (
        open_api(tmp_path, trust_loopback=False) as api,
        _door_of_the_user(api.settings) as doors,
        served(api, *doors) as url,
    ):
        compared(equal("permissions", expected="srw-------", got=stat.filemode((tmp_path / SOCKET).stat().st_mode)))
        compared(equal("loopback", expected=401, got=httpx.get(f"{url}/v1/sweeps").status_code))
        with Client() as client:
            id = client.submit(SWEEP).id
        compared(equal("whipple queue --pause", expected=0, got=run("queue", "--pause")))
        assert client_of(DEFAULT_URL, None).url == DEFAULT_URL != client_of(None, None).url
        trail = api.store.audit.entries(api.store.sweeps.get(id).created)
        got = [(entry.action, entry.address, entry.outcome) for entry in trail]
        compared(equal("trail", expected=[("submit", "socket", "202"), ("pause", "socket", "200")], got=got))
        monkeypatch.setattr(os, "geteuid", lambda: 1 + os.getuid())
        compared(equal("client of another user", expected=DEFAULT_URL, got=Client().url))
    assert not (tmp_path / SOCKET).exists()


def test_socket__that_was_left_is_removed_and_one_without_a_place_refused(tmp_path: Path) -> None:
    (tmp_path / SOCKET).touch()
    with _door_of_the_user(Settings(data=tmp_path)) as doors:
        assert (doors, (tmp_path / SOCKET).exists()) == ([], False)
    settings = Settings(data=tmp_path / ("x" * 120), trust_loopback=False)
    with pytest.raises(InvalidInput, match="shorter path"), _door_of_the_user(settings):
        pass
