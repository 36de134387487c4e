"""API keys, and sessions of browsers that logged in with one.

A secret is shown once, at its creation; the store has its SHA-256.
"""

import hashlib
import hmac
import secrets
import uuid
from collections.abc import Iterable
from contextlib import suppress
from datetime import datetime, timedelta
from threading import Lock, Thread

import sqlalchemy as sa

from service.records.jobs import Conflict, KeyRow, Scope, StoreUnavailable
from service.store.connection import Database, Repository
from service.store.tables import KEYS, SESSIONS, StatementRow, now

MARK = "whp_"  # by which people and secret scanners recognise a secret of this service
PREFIX_LENGTH = len(MARK) + 8
SECRET_BYTES = 32
USED_EVERY = timedelta(minutes=1)  # interval between two notes of the use of a key
SESSION = timedelta(hours=12)  # a working day, after which a browser logs in again


class Keys(Repository):
    """Keys that requests need elsewhere than on the loopback."""

    def __init__(self, database: Database):
        super().__init__(database)
        self._noting = Lock()  # held while a use is noted

    def issue(self, name: str, scopes: Iterable[Scope], expires: datetime | None = None) -> tuple[KeyRow, str]:
        """Issue a key; return it with its secret, which is stored nowhere."""
        secret = MARK + secrets.token_urlsafe(SECRET_BYTES)
        row = {
            "id": uuid.uuid4().hex,
            "name": name,
            "prefix": secret[:PREFIX_LENGTH],
            "sha256": _digest(secret),
            "scopes": " ".join(sorted(scopes)),
            "created": now(),
            "expires": expires,
        }
        insert = KEYS.insert().values(row).returning(KEYS)
        with self._database.writing() as connection:
            return _record(connection.execute(insert).one()), secret

    def rotate(self, key: KeyRow, grace: timedelta) -> tuple[KeyRow, str]:
        """Issue a key of the same name, scopes and lifetime; ``key`` itself ends after ``grace``. Raises Conflict."""
        moment = now()
        if not key.is_usable(moment):
            raise Conflict(f"the key {key.name!r} is revoked or expired; create another")
        until = None if key.expires is None else moment + (key.expires - key.created)
        issued = self.issue(key.name, key.scopes, until)
        self._set(key.id, expires=min(filter(None, (key.expires, moment + grace))))
        return issued

    def find(self, secret: str, *, ended: bool = False) -> KeyRow | None:
        """The usable key with this secret, whose use is noted in the background, once a minute; or an ``ended`` one."""
        if not (secret.isascii() and secret.isprintable()):
            return None
        digest, moment = _digest(secret), now()
        query = sa.select(KEYS).where(KEYS.c.prefix == secret[:PREFIX_LENGTH], _is_usable(moment) != ended)
        rows = self._database.rows(query)
        key = next((_record(row) for row in rows if hmac.compare_digest(row.sha256, digest)), None)
        if key is not None and not ended and (key.used is None or abs(moment - key.used) > USED_EVERY):
            self._note_use(key.id, moment)
        return key

    def begin_session(self, key: KeyRow) -> str:
        """Begin a session of a key; return its secret. Sessions past their time are removed."""
        secret, moment = secrets.token_urlsafe(SECRET_BYTES), now()
        row = {"sha256": _digest(secret), "key_id": key.id, "expires": moment + SESSION}
        with self._database.writing() as connection:
            connection.execute(SESSIONS.delete().where(SESSIONS.c.expires <= moment))
            connection.execute(SESSIONS.insert().values(row))
        return secret

    def of_session(self, secret: str) -> KeyRow | None:
        """The usable key with which a session was begun; None for a session that has ended."""
        moment = now()
        query = sa.select(KEYS).join_from(KEYS, SESSIONS).where(SESSIONS.c.sha256 == _digest(secret))
        rows = self._database.rows(query.where(SESSIONS.c.expires > moment, _is_usable(moment)))
        return _record(rows[0]) if rows else None

    def end_session(self, secret: str) -> None:
        """End a session, if it lasts."""
        with self._database.writing() as connection:
            connection.execute(SESSIONS.delete().where(SESSIONS.c.sha256 == _digest(secret)))

    def any_usable(self) -> bool:
        """Whether there is a key that can be used now."""
        return self._database.value(sa.select(sa.exists().where(_is_usable(now()))))

    def all(self) -> tuple[KeyRow, ...]:
        """All keys, expired and revoked ones too, oldest first."""
        return tuple(map(_record, self._database.rows(sa.select(KEYS).order_by(KEYS.c.created, KEYS.c.id))))

    def revoke(self, id: str) -> KeyRow:
        """Make a key useless from now on; raises NotFound."""
        key = _record(self._database.row(sa.select(KEYS).where(KEYS.c.id == id), "key", id))
        return key if key.revoked is not None else self._set(id, revoked=now())

    def _note_use(self, id: str, moment: datetime) -> None:
        """Note a use in a thread, one at a time: a request does not wait for other writers."""

        def write() -> None:
            try:
                with suppress(StoreUnavailable):  # the next use is noted again
                    self._set(id, used=moment)
            finally:
                self._noting.release()

        if self._noting.acquire(blocking=False):
            Thread(target=write, name="key use", daemon=True).start()

    def _set(self, id: str, **values: datetime) -> KeyRow:
        update = KEYS.update().where(KEYS.c.id == id).values(values).returning(KEYS)
        with self._database.writing() as connection:
            return _record(connection.execute(update).one())  # keys are never deleted


def _record(row: StatementRow) -> KeyRow:
    values = {name: getattr(row, name) for name in KeyRow.__dataclass_fields__ if name != "scopes"}
    return KeyRow(**values, scopes=frozenset(map(Scope, row.scopes.split())))


def _digest(secret: str) -> str:
    return hashlib.sha256(secret.encode()).hexdigest()


def _is_usable(moment: datetime) -> sa.ColumnElement[bool]:
    return KEYS.c.revoked.is_(None) & sa.or_(KEYS.c.expires.is_(None), KEYS.c.expires > moment)
