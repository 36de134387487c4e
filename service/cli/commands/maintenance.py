"""Maintenance of the database and the files of a service: keys, audit, backup, retention, missing files, remeasure."""

import re
import sys
from contextlib import nullcontext, suppress
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from service.cli.commands.options import FAILURE, SOME_FAILED, SUCCESS, Data, DatabaseUrl, Json, settings_of
from service.cli.console import (
    SHORT_ID,
    print_audit,
    print_backup,
    print_check,
    print_expired,
    print_json,
    print_keys,
    print_plan,
    print_remeasured,
    tracking,
)
from studies.quantities.findings import Finding, InvalidInput

if TYPE_CHECKING:
    from service.records.jobs import KeyRow

app = typer.Typer()
keys = typer.Typer(no_args_is_help=True)
app.add_typer(keys, name="keys", help="API keys, which requests from other machines need.")

DURATION = re.compile(r"([1-9]\d{0,5})([dhm])")
UNITS = {"d": "days", "h": "hours", "m": "minutes"}
KeyArgument = Annotated[
    str, typer.Argument(metavar="KEY", help="Id or prefix of a key, as `list` prints it, or the name of a usable one.")
]


@keys.command("create")
def create_key(
    name: Annotated[str, typer.Argument(help="Owner of the sweeps submitted with the key.")],
    scope: Annotated[
        list[str] | None, typer.Option(help="read, submit (default) or admin; each includes those before it.")
    ] = None,
    expires: Annotated[
        str | None, typer.Option(help="Lifetime, such as 90d, 12h or 30m; by default unlimited.")
    ] = None,
    data: Data = None,
    database_url: DatabaseUrl = None,
) -> None:
    """Create a key, and print its secret once: it is not stored."""
    from service.cli.offline import open_store, record_command
    from service.records.jobs import Scope

    unknown = [word for word in scope or () if word not in list(Scope)]
    if unknown:
        limit = " or ".join(Scope)
        raise InvalidInput([Finding("--scope", unknown[0], limit, "write one of these")])
    if not name.strip() or not name.isprintable():
        raise InvalidInput([Finding("NAME", repr(name), "a printable name", "write a name")])
    scopes = [Scope(word) for word in scope or ["submit"]]
    until = None if expires is None else datetime.now(UTC) + _duration("--expires", expires)
    with open_store(settings_of(data=data, database_url=database_url), create=True) as store:
        others = sum(key.name == name.strip() for key in store.keys.all())
        row, secret = store.keys.issue(name.strip(), scopes, until)
        _print_secret(row, secret)
        if others:
            count = "another key is" if others == 1 else f"{others} other keys are"
            text = (
                f"{count} named {row.name}: they share their sweeps and quotas, and each may cancel and delete them all"
            )
            print(f"{text}; for an owner apart revoke this one, and choose another name", file=sys.stderr)
        record_command(store, "key created", row.id)


@keys.command("rotate")
def rotate_key(
    key: KeyArgument,
    grace: Annotated[str, typer.Option(help="How long the old secret is still valid, such as 7d, 12h or 30m.")] = "7d",
    data: Data = None,
    database_url: DatabaseUrl = None,
) -> None:
    """Replace a key by one of the same name, scopes and lifetime, and print its secret once; the old one ends later."""
    from service.cli.offline import open_store, record_command

    with open_store(settings_of(data=data, database_url=database_url)) as store:
        old = _matching(key, store.keys.all())
        row, secret = store.keys.rotate(old, _duration("--grace", grace))
        _print_secret(row, secret)
        record_command(store, "key rotated", old.id)


def _print_secret(row: "KeyRow", secret: str) -> None:
    print(secret)
    print_keys([row], file=sys.stderr)
    print("save the secret: it cannot be shown again", file=sys.stderr)


@keys.command("list")
def list_keys(as_json: Json = False, data: Data = None, database_url: DatabaseUrl = None) -> None:
    """List all keys, without their secrets."""
    from service.cli.offline import open_store

    with open_store(settings_of(data=data, database_url=database_url)) as store:
        rows = store.keys.all()
    print_json([vars(row) for row in rows]) if as_json else print_keys(rows)


@keys.command("revoke")
def revoke_key(key: KeyArgument, data: Data = None, database_url: DatabaseUrl = None) -> None:
    """Revoke a key, from the next request on."""
    from service.cli.offline import open_store, record_command

    with open_store(settings_of(data=data, database_url=database_url)) as store:
        revoked = store.keys.revoke(_matching(key, store.keys.all()).id)
        print_keys([revoked])
        record_command(store, "key revoked", revoked.id)


def _duration(option: str, text: str) -> timedelta:
    """A duration; raises InvalidInput."""
    match = DURATION.fullmatch(text)
    if match is None:
        limit = "a whole number of days (d), hours (h) or minutes (m), at least 1m"
        raise InvalidInput([Finding(option, text, limit, "write it like 90d, 12h or 30m")])
    return timedelta(**{UNITS[match[2]]: int(match[1])})


def _matching(text: str, rows: "tuple[KeyRow, ...]") -> "KeyRow":
    """The one key whose id or secret begins so, or the usable one of a name; raises InvalidInput."""
    moment = datetime.now(UTC)
    matching = [row for row in rows if text and (row.id.startswith(text) or text == row.prefix)]
    matching = matching or [row for row in rows if row.name == text and row.is_usable(moment)]
    if len(matching) != 1:
        candidates = ", ".join(f"{row.id[:SHORT_ID]} ({row.name})" for row in matching)
        limit = "the beginning of one id" if matching else "the id of a key"
        cure = f"write more of it: {candidates}" if matching else "see `whipple keys list`"
        raise InvalidInput([Finding("KEY", text, limit, cure)])
    return matching[0]


@app.command()
def audit(
    since: Annotated[datetime | None, typer.Option(help="First time, in UTC.")] = None,
    owner: Annotated[str | None, typer.Option(help="Name of a key, or of a user of the service's machine.")] = None,
    action: Annotated[str | None, typer.Option(help="Such as submit, cancel, or `refused key`.")] = None,
    as_json: Json = False,
    data: Data = None,
    database_url: DatabaseUrl = None,
) -> None:
    """List the orders that the service was given: who, from where, and what came of it; oldest first."""
    from service.cli.offline import open_store

    with open_store(settings_of(data=data, database_url=database_url)) as store:
        entries = store.audit.entries((since or datetime.min).replace(tzinfo=UTC), owner=owner, action=action)
    print_json([vars(entry) for entry in entries]) if as_json else print_audit(entries)


@app.command()
def doctor(as_json: Json = False, data: Data = None, database_url: DatabaseUrl = None) -> None:
    """Check data directory, database and workers, and print cures. The exit status is 1 on an error."""
    from service.cli.doctor import CheckStatus, examine

    checks = []
    for check in examine(settings_of(data=data, database_url=database_url)):
        checks.append(check)
        if not as_json:
            print_check(check)
    if as_json:
        print_json([vars(check) for check in checks])
    errors = sum(check.status is CheckStatus.ERROR for check in checks)
    raise typer.Exit(FAILURE if errors else SUCCESS)


@app.command()
def backup(
    out: Annotated[Path, typer.Argument(metavar="OUT", help="Folder; an earlier backup there is updated.")],
    data: Data = None,
) -> None:
    """Copy database and files (SQLite) while the service runs. OUT then is a data directory."""
    from service.cli.backup import back_up
    from service.cli.offline import open_store

    settings = settings_of(data=data)
    with open_store(settings) as store:
        done = back_up(settings, out, store)
    print_backup(done)
    raise typer.Exit(FAILURE if done.lost else SUCCESS)


@app.command()
def retention(
    older_than: Annotated[
        str | None, typer.Option(help="Sweeps that ended so long ago, such as 90d, 12h or 30m.")
    ] = None,
    to_size: Annotated[
        str | None, typer.Option(help="The oldest sweeps, until the files of the others have 500GB, or another size.")
    ] = None,
    owner: Annotated[str | None, typer.Option(help="Sweeps of the owner, the name of a key, alone.")] = None,
    apply: Annotated[bool, typer.Option("--apply", help="Delete them; by default they are listed.")] = False,
    trust_clock: Annotated[
        bool, typer.Option("--trust-clock", help="Say that the clock is right: the service deletes by age again.")
    ] = False,
    as_json: Json = False,
    data: Data = None,
    database_url: DatabaseUrl = None,
) -> None:
    """List, or delete, ended sweeps by age, size and owner; pinned ones stay, and runs that another sweep has."""
    from service.cli.offline import open_store, record_command
    from service.records.jobs import Conflict, NotFound

    if trust_clock:
        with open_store(settings_of(data=data, database_url=database_url)) as store:
            store.retention.trust_clock()
            record_command(store, "trust clock")
        print("the clock is believed: the service deletes by age again")
        return
    if older_than is None and to_size is None and owner is None:
        raise InvalidInput([Finding("retention", "no rule", "--older-than, --to-size or --owner", "give one of them")])
    before = datetime.now(UTC) - (timedelta() if older_than is None else _duration("--older-than", older_than))
    most = -1 if to_size is None else _size("--to-size", to_size)
    with open_store(settings_of(data=data, database_url=database_url)) as store:
        expired = store.retention.expired(before, owner=owner, to_size=most)
        statuses = store.sweeps.statuses(expired) if as_json else {}
        for id in expired if apply else ():
            with suppress(Conflict, NotFound):  # it was pinned, retried or deleted just now
                store.sweeps.delete(id)
                record_command(store, "delete", id)
    if as_json:
        print_json([{**vars(status), "size": expired[id].size} for id, status in statuses.items()])
    else:
        print_expired([*expired.values()])
    if not apply:
        print("nothing was deleted: --apply deletes them", file=sys.stderr)


def _size(option: str, text: str) -> int:
    """The bytes that an option gives; raises InvalidInput."""
    from pydantic import ByteSize, TypeAdapter, ValidationError

    try:
        return TypeAdapter(ByteSize).validate_python(text)
    except ValidationError:
        raise InvalidInput([Finding(option, text, "a size", "write it like 500GB or 2TiB")]) from None


@app.command()
def adopt(data: Data = None, database_url: DatabaseUrl = None) -> None:
    """Assign a data directory to a database after one of them was replaced: both get the same id."""
    from service.cli.offline import open_store, record_command
    from service.queue import data_identity as identity

    settings = settings_of(data=data, database_url=database_url)
    with open_store(settings) as store:
        id = identity.adopt(settings, store)
        record_command(store, "adopt")
    print(f"{settings.data.absolute()} and its database have the id {id}")


@app.command("forget-lost")
def forget_lost(
    count: Annotated[int, typer.Argument(metavar="COUNT", min=0, help="Number of results, as the service reports.")],
    data: Data = None,
    database_url: DatabaseUrl = None,
) -> None:
    """Allow the service to compute COUNT lost results again, beyond its own limit; 0 withdraws that."""
    from service.cli.offline import open_store, record_command

    with open_store(settings_of(data=data, database_url=database_url)) as store:
        store.queue.allow_forgetting(count)
        record_command(store, "forget lost")
    print(f"{count} lost results may be computed again; the service starts them within a minute")


@app.command()
def remeasure(
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Only list the outdated results.")] = False,
    data: Data = None,
    database_url: DatabaseUrl = None,
) -> None:
    """Apply changed definitions of measurements to the stored final states; stop the service first."""
    from service.cli.offline import open_store, record_command, without_services
    from service.cli.remeasuring import Remeasured, plan_of, remeasure_runs

    settings = settings_of(data=data, database_url=database_url)
    done: list[Remeasured] = []
    with open_store(settings) as store, nullcontext() if dry_run else without_services(settings, store):
        plan = plan_of(store)
        print_plan(plan)
        if dry_run or not plan.measurable:
            return
        record_command(store, "remeasure")
        runs = remeasure_runs(settings, store, plan.measurable)
        try:
            done.extend(tracking(runs, len(plan.measurable)))
        finally:
            # Also after an interruption.
            print_remeasured(done, plan.sweeps)
    raise typer.Exit(SOME_FAILED if any(result.reason for result in done) else SUCCESS)
