"""Events: what happened to sweeps and jobs, appended in the transaction that makes it true; and who ordered it."""

import logging
from dataclasses import asdict
from datetime import datetime
from typing import TYPE_CHECKING

import sqlalchemy as sa

from service.records.jobs import AuditEntry, Event, Lease
from service.store.connection import Repository
from service.store.tables import AUDIT, EVENTS, runs_of

if TYPE_CHECKING:
    from studies.quantities.parameters import Plain

log = logging.getLogger(__name__)


class Events(Repository):
    """Pages of events, oldest first."""

    def of_sweep(self, sweep_id: str, *, after: int = 0, limit: int = 1000) -> tuple[Event, ...]:
        """Events of a sweep and its runs since it was accepted."""
        of_sweep = EVENTS.c.sweep_id == sweep_id
        first = sa.select(sa.func.min(EVENTS.c.number)).where(of_sweep).scalar_subquery()
        which = sa.or_(of_sweep, EVENTS.c.job_id.in_(runs_of(sweep_id)))
        return self._page(sa.and_(which, EVENTS.c.number >= first), after, limit)

    def of_run(self, run_id: str, *, after: int = 0, limit: int = 1000) -> tuple[Event, ...]:
        return self._page(EVENTS.c.job_id == run_id, after, limit)

    def all(self, *, after: int = 0, limit: int = 1000) -> tuple[Event, ...]:
        return self._page(sa.true(), after, limit)

    def last(self) -> int:
        """Number of the youngest event; 0: nothing has happened yet."""
        return self._database.value(sa.select(sa.func.coalesce(sa.func.max(EVENTS.c.number), 0)))

    def _page(self, which: sa.ColumnElement[bool], after: int, limit: int) -> tuple[Event, ...]:
        query = sa.select(EVENTS).where(EVENTS.c.number > after, which).order_by(EVENTS.c.number).limit(limit)
        return tuple(Event(*row) for row in self._database.rows(query))


class AuditTrail(Repository):
    """Orders and refused keys: who gave them, from where, and what came of them. Rows are added, never changed."""

    def record(self, entry: AuditEntry) -> None:
        """Add an entry; one that the database cannot take is in the log alone: its order is carried out already."""
        line = {**asdict(entry), "caller": entry.owner, "key": entry.key_id}
        log.info("%s: %s", entry.action, entry.outcome, extra=line)
        try:
            with self._database.writing() as connection:
                connection.execute(AUDIT.insert().values(asdict(entry)))
        except Exception:
            log.exception("an order is in the log, and not in the audit trail", extra=line)

    def entries(self, since: datetime, **exactly: str | None) -> tuple[AuditEntry, ...]:
        """The entries from a moment on, of an ``owner`` or an ``action`` if one is asked for; oldest first."""
        asked = {name: value for name, value in exactly.items() if value is not None}
        columns = [AUDIT.c[name] for name in AuditEntry.__dataclass_fields__]
        query = sa.select(*columns).where(AUDIT.c.time >= since).filter_by(**asked).order_by(AUDIT.c.number)
        return tuple(AuditEntry(*row) for row in self._database.rows(query))


def log_event(
    connection: sa.Connection,
    moment: datetime,
    kind: str,
    *,
    sweep_id: str | None = None,
    job_id: str | None = None,
    **body: "Plain",
) -> None:
    """Append an event, in the transaction that makes it true."""
    connection.execute(EVENTS.insert().values(time=moment, kind=kind, sweep_id=sweep_id, job_id=job_id, body=body))


def log_attempts(connection: sa.Connection, moment: datetime, kind: str, *leases: Lease, **body: "Plain") -> None:
    """Append an event of each of these attempts."""
    same = {"time": moment, "kind": kind}
    rows = [
        {**same, "sweep_id": lease.sweep_id, "job_id": lease.id, "body": {"attempt": lease.attempt, **body}}
        for lease in leases
    ]
    connection.execute(EVENTS.insert(), rows)
