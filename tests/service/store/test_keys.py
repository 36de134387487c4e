"""API keys: shown once, stored as a digest, their use noted."""

from datetime import timedelta

import pytest
import sqlalchemy as sa

from service.records.jobs import Conflict, Scope
from service.store import Store
from service.store.tables import KEYS, now
from tests.service.support.fakes import wait_until

BOTH = frozenset({Scope.READ, Scope.SUBMIT})


def test_key__is_found_by_its_secret_which_is_stored_nowhere(store: Store) -> None:
    key, secret = store.keys.issue("ann", BOTH)
    present = store.keys.find(secret)
    assert present is not None
    assert (present.id, present.name, present.scopes) == (key.id, "ann", BOTH)
    with store.database.reading() as reading:
        [row] = reading.execute(sa.select(KEYS)).all()
    assert secret.removeprefix(row.prefix) not in str(row)
    assert len(secret) > len(row.prefix) + 32


def test_use_of_a_key__is_noted_once_a_minute_beside_other_writers(store: Store) -> None:
    _, secret = store.keys.issue("ann", BOTH)
    with store.database.writing():  # which a request does not wait for
        assert store.keys.find(secret) is not None
        assert store.keys.all()[0].used is None
    first = wait_until(lambda: store.keys.all()[0].used)
    before = first - timedelta(minutes=2)
    for used, is_noted in ((first, False), (before, True)):
        with store.database.writing() as writing:
            writing.execute(KEYS.update().values(used=used))
        store.keys.find(secret)
        if is_noted:
            assert wait_until(lambda: store.keys.all()[0].used != before)
        else:
            assert store.keys.all()[0].used == first


@pytest.mark.claim("doors", "rotation")
def test_rotated_key__is_valid_beside_its_successor_for_the_grace_period(
    store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A rotated key and its successor, of the same name, scopes and lifetime, are both valid for the grace period."""
    begin = now()
    monkeypatch.setattr("service.store.keys.now", lambda: begin)
    old, old_secret = store.keys.issue("ann", BOTH, begin + timedelta(days=90))
    new, new_secret = store.keys.rotate(old, timedelta(days=7))
    assert (new.name, new.scopes, new.expires) == ("ann", BOTH, begin + timedelta(days=90))
    for days, valid in ((6, [True, True]), (8, [False, True]), (91, [False, False])):
        monkeypatch.setattr("service.store.keys.now", lambda days=days: begin + timedelta(days=days))
        assert [store.keys.find(secret) is not None for secret in (old_secret, new_secret)] == valid
    assert store.keys.find(old_secret, ended=True) is not None
    with pytest.raises(Conflict, match="expired"):
        store.keys.rotate(new, timedelta(days=7))
    short, _ = store.keys.issue("bert", BOTH, begin + timedelta(days=92))
    store.keys.rotate(short, timedelta(days=7))
    assert short in store.keys.all()  # ends no later
