"""The bytes of files that each owner has: sums that triggers of the database keep, whatever statement changes them.

A file belongs to the owner of its job. A run that no sweep has any more (``abandoned``) belongs to nobody. A trigger
changes the sum in the transaction that adds, replaces or removes a file, or gives a job to another owner. So a quota
costs the same however much an owner has stored. Of many rows PostgreSQL has the sums changed once, for it keeps each
version of a row until the end of the transaction, and looks at all of them for the next.
"""

from collections.abc import Iterator, Mapping

import sqlalchemy as sa

from service.store.tables import ARTIFACTS, JOBS, OWNED_BYTES

_ADD = "ON CONFLICT (owner) DO UPDATE SET bytes = owned_bytes.bytes + excluded.bytes"

# Of each trigger its event, and the owners with the bytes that they get, for one row.
_OF_FILE = "SELECT owner, {bytes} FROM jobs WHERE id = {row}.job_id AND abandoned IS NULL"
_OF_JOB = """SELECT {row}.owner, {sign}sum(size) FROM artifacts
    WHERE job_id = {row}.id AND {row}.abandoned IS NULL GROUP BY job_id"""
_IS_MOVED = "(OLD.owner <> NEW.owner OR (OLD.abandoned IS NULL) <> (NEW.abandoned IS NULL))"
_SQLITE = {
    "files_added": ("INSERT ON artifacts", "", [_OF_FILE.format(row="NEW", bytes="NEW.size")]),
    "files_removed": ("DELETE ON artifacts", "", [_OF_FILE.format(row="OLD", bytes="-OLD.size")]),
    "files_replaced": ("UPDATE OF size ON artifacts", "", [_OF_FILE.format(row="NEW", bytes="NEW.size - OLD.size")]),
    "jobs_moved": (
        "UPDATE OF owner, abandoned ON jobs",
        f"WHEN {_IS_MOVED}",
        [_OF_JOB.format(row="OLD", sign="-"), _OF_JOB.format(row="NEW", sign="")],
    ),
}

# The same for all rows of a statement. A subquery for each row is read through an index, whatever number of rows the
# server had in mind when it planned.
_OF_FILES = (
    "SELECT (SELECT owner FROM jobs WHERE id = job_id AND abandoned IS NULL) AS owner, {sign}size AS bytes FROM {rows}"
)
# Of jobs that stay with their owner both sums are the same. They are not joined: the server keeps the plan that it made
# for the first few rows, and of 10 000 rows a join by it takes 90 s (PostgreSQL 18, 2026-11).
_OF_JOBS = """SELECT owner, {sign}(SELECT sum(size) FROM artifacts WHERE job_id = {rows}.id) AS bytes
    FROM {rows} WHERE abandoned IS NULL"""
_REMOVED, _ADDED = _OF_FILES.format(rows="removed", sign="-"), _OF_FILES.format(rows="added", sign="")
_LEFT, _RECEIVED = (_OF_JOBS.format(rows=rows, sign=sign) for rows, sign in (("removed", "-"), ("added", "")))
_POSTGRESQL = {
    "files_added": ("INSERT ON artifacts", "NEW TABLE AS added", _ADDED),
    "files_removed": ("DELETE ON artifacts", "OLD TABLE AS removed", _REMOVED),
    "files_replaced": (
        "UPDATE ON artifacts",
        "OLD TABLE AS removed NEW TABLE AS added",
        f"{_REMOVED} UNION ALL {_ADDED}",
    ),
    "jobs_moved": ("UPDATE ON jobs", "OLD TABLE AS removed NEW TABLE AS added", f"{_LEFT} UNION ALL {_RECEIVED}"),
}

_SUMS = (
    sa.select(JOBS.c.owner, sa.func.sum(ARTIFACTS.c.size).label("bytes"))
    .join_from(ARTIFACTS, JOBS, JOBS.c.id == ARTIFACTS.c.job_id)
    .where(JOBS.c.abandoned.is_(None))
    .group_by(JOBS.c.owner)
)


def install(connection: sa.Connection) -> None:
    """Make the triggers, in place of earlier ones, and count what is there; after the tables were made or changed."""
    for statement in _statements_of(connection.dialect.name):
        connection.exec_driver_sql(statement)
    recount(connection)


def _statements_of(dialect: str) -> Iterator[str]:
    if dialect == "sqlite":
        for name, (event, condition, sources) in _SQLITE.items():
            changes = " ".join(f"INSERT INTO owned_bytes (owner, bytes) {source} {_ADD};" for source in sources)
            yield f"DROP TRIGGER IF EXISTS {name}"
            yield f"CREATE TRIGGER {name} AFTER {event} {condition} BEGIN {changes} END"
        return
    for name, (event, tables, source) in _POSTGRESQL.items():
        change = f"INSERT INTO owned_bytes (owner, bytes) SELECT owner, sum(bytes) FROM ({source}) AS changes"
        change = f"{change} WHERE owner IS NOT NULL GROUP BY owner HAVING sum(bytes) <> 0 {_ADD};"
        body = f"BEGIN {change} RETURN NULL; END"
        yield f"CREATE OR REPLACE FUNCTION {name}() RETURNS trigger LANGUAGE plpgsql AS $$ {body} $$"
        yield f"DROP TRIGGER IF EXISTS {name} ON {event.split()[-1]}"
        yield f"CREATE TRIGGER {name} AFTER {event} REFERENCING {tables} FOR EACH STATEMENT EXECUTE FUNCTION {name}()"


def recount(connection: sa.Connection) -> None:
    """Replace the kept sums by those of the files."""
    connection.execute(OWNED_BYTES.delete())
    connection.execute(OWNED_BYTES.insert().from_select(["owner", "bytes"], _SUMS))


def differences(connection: sa.Connection) -> Mapping[str, tuple[int, int]]:
    """Owners whose kept sum is not that of their files, each with both."""
    kept = {row.owner: int(row.bytes) for row in connection.execute(sa.select(OWNED_BYTES))}
    right = {row.owner: int(row.bytes) for row in connection.execute(_SUMS)}
    both = {owner: (kept.get(owner, 0), right.get(owner, 0)) for owner in kept.keys() | right.keys()}
    return {owner: sums for owner, sums in both.items() if sums[0] != sums[1]}
