"""API keys: told once, stored as a digest, useless once revoked or expired."""

import time
from datetime import timedelta

import pytest
import sqlalchemy as sa

from service.records.jobs import KeyRow, NotFound, Scope, StoreUnavailable
from service.store import Store
from service.store.connection import BUSY_MILLISECONDS
from service.store.queries import now
from service.store.tables import KEYS
from tests.service.support.fakes import wait_until

BOTH = frozenset({Scope.READ, Scope.SUBMIT})


def test_key__is_found_by_its_secret(store: Store) -> None:
    key, secret = store.create_key("ann", BOTH)
    found = store.find_key(secret)
    assert found is not None
    assert (found.id, found.name, found.scopes) == (key.id, "ann", BOTH)
    assert secret.startswith(key.prefix)
    assert len(secret) > len(key.prefix) + 32


@pytest.mark.parametrize("wrong", ["", "whp_", "x", "whp_ümläut", "whp_\udcff", "whp_\x00"])
def test_key__nothing_else_finds_it(store: Store, wrong: str) -> None:
    key, secret = store.create_key("ann", BOTH)
    assert store.find_key(wrong) is None
    assert store.find_key(secret + "x") is None
    assert store.find_key(key.prefix) is None


def test_key__its_secret_is_not_stored(store: Store) -> None:
    _, secret = store.create_key("ann", BOTH)
    with store._database.reading() as reading:
        [row] = reading.execute(sa.select(KEYS)).all()
    assert secret not in str(row)
    assert secret.removeprefix(row.prefix) not in str(row)


def test_key__once_revoked_it_is_useless(store: Store) -> None:
    key, secret = store.create_key("ann", BOTH)
    revoked = store.revoke_key(key.id)
    assert revoked.revoked is not None
    assert store.find_key(secret) is None
    assert store.revoke_key(key.id) == revoked
    assert store.keys() == (revoked,)
    with pytest.raises(NotFound, match="key"):
        store.revoke_key("another")


def test_key__once_expired_it_is_useless(store: Store) -> None:
    _, past = store.create_key("ann", BOTH, now() - timedelta(seconds=1))
    _, future = store.create_key("bob", BOTH, now() + timedelta(days=1))
    assert store.find_key(past) is None
    assert store.find_key(future) is not None


def test_key__whether_there_is_one_that_can_be_used(store: Store) -> None:
    assert not store.has_keys()
    store.create_key("ann", BOTH, now() - timedelta(seconds=1))
    assert not store.has_keys()
    key, _ = store.create_key("bob", BOTH)
    assert store.has_keys()
    store.revoke_key(key.id)
    assert not store.has_keys()


def noted(store: Store) -> KeyRow:
    """The only key, once its use is noted."""
    wait_until(lambda: store.keys()[0].used is not None and not store._noting.locked())
    return store.keys()[0]


def test_key__its_last_use_is_noted_once_a_minute(store: Store) -> None:
    key, secret = store.create_key("ann", BOTH)
    assert key.used is None
    store.find_key(secret)
    first = noted(store)
    assert first.used is not None
    store.find_key(secret)
    assert noted(store) == first
    before = first.used - timedelta(minutes=2)
    with store._database.writing() as writing:
        writing.execute(KEYS.update().values(used=before))
    store.find_key(secret)
    later = noted(store)
    assert later.used is not None
    assert later.used >= first.used


def test_key__is_found_while_somebody_writes_and_its_use_is_noted_afterwards(store: Store) -> None:
    key, secret = store.create_key("ann", BOTH)
    with store._database.writing():
        begin = time.monotonic()
        for _ in range(3):
            assert store.find_key(secret) is not None
        assert time.monotonic() - begin < BUSY_MILLISECONDS / 1000
        [unknown] = store.keys()
        assert unknown.used is None
    assert noted(store).id == key.id


def test_key__is_found_though_its_use_cannot_be_noted(
    store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    def locked(*_arguments: object, **_words: object) -> None:
        raise StoreUnavailable("locked")

    _, secret = store.create_key("ann", BOTH)
    monkeypatch.setattr(Store, "_set", locked)
    assert store.find_key(secret) is not None
    wait_until(lambda: not store._noting.locked())
    assert store.find_key(secret) is not None
