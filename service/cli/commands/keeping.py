"""What is done where database and files are: keys, doctor, backup, adopt, forget-lost, remeasure."""

import re
import sys
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from service.cli.commands.options import (
    FINE,
    SOME_FAILED,
    WRONG,
    Data,
    DatabaseUrl,
    settings_of,
)
from studies.values.errors import Finding, InvalidInput

if TYPE_CHECKING:
    from datetime import timedelta

    from service.records.jobs import KeyRow, Scope


app = typer.Typer()
keys = typer.Typer(no_args_is_help=True)
app.add_typer(keys, name="keys", help="API keys: who may ask a service that listens elsewhere.")

SPAN = re.compile(r"(\d{1,6})([dhm])")
UNITS = {"d": "days", "h": "hours", "m": "minutes"}


# --- keys -----------------------------------------------------------------------------------------


@keys.command("create")
def create_key(
    name: Annotated[str, typer.Argument(help="Whose key it is: the owner of what is submitted.")],
    scope: Annotated[
        list[str] | None,
        typer.Option(help="read, submit (the default) or admin; each allows what is before it."),
    ] = None,
    expires: Annotated[
        str | None, typer.Option(help="After so long it is of no use: 90d, 12h, 30m; else never.")
    ] = None,
    data: Data = None,
    database_url: DatabaseUrl = None,
) -> None:
    """Make a key, and print its secret: once, it is not stored."""
    from datetime import UTC, datetime

    from service.cli.console import print_key
    from service.cli.offline import open_store

    scopes, span = _scopes(scope or ["submit"]), _span(expires)
    until = None if span is None else datetime.now(UTC) + span
    with open_store(settings_of(data=data, database_url=database_url), make=True) as store:
        row, secret = store.create_key(_name(name), scopes, until)
    print(secret)
    print_key(row, file=sys.stderr)
    print("keep it: it is not told again", file=sys.stderr)


@keys.command("list")
def list_keys(data: Data = None, database_url: DatabaseUrl = None) -> None:
    """Show all keys, without their secrets."""
    from service.cli.console import print_key
    from service.cli.offline import open_store

    with open_store(settings_of(data=data, database_url=database_url)) as store:
        known = store.keys()
    for row in known:
        print_key(row)


@keys.command("revoke")
def revoke_key(
    key: Annotated[
        str, typer.Argument(metavar="KEY", help="Id or begin of a key, as `list` shows it.")
    ],
    data: Data = None,
    database_url: DatabaseUrl = None,
) -> None:
    """Make a key useless, from the next request on."""
    from service.cli.console import print_key
    from service.cli.offline import open_store

    with open_store(settings_of(data=data, database_url=database_url)) as store:
        print_key(store.revoke_key(_meant(key, store.keys()).id))


# --- doctor ---------------------------------------------------------------------------------------


@app.command()
def doctor(data: Data = None, database_url: DatabaseUrl = None) -> None:
    """Check data directory, store and workers, with a cure for what is wrong. Ends with 1 if something is."""
    from service.cli.console import print_check
    from service.cli.doctor import Verdict, examine

    settings = settings_of(data=data, database_url=database_url)
    wrong = 0
    for check in examine(settings):
        print_check(check)
        wrong += check.verdict is Verdict.WRONG
    raise typer.Exit(WRONG if wrong else FINE)


# --- backup ---------------------------------------------------------------------------------------


@app.command()
def backup(
    out: Annotated[
        Path, typer.Argument(metavar="OUT", help="Folder; an earlier backup is brought up to date.")
    ],
    data: Data = None,
) -> None:
    """Copy database and files (SQLite) while the service runs. OUT then is a data directory."""
    from service.cli.backup import back_up
    from service.cli.console import print_backup
    from service.cli.offline import open_store

    settings = settings_of(data=data)
    with open_store(settings) as store:
        done = back_up(settings, out, store)
    print_backup(done)
    raise typer.Exit(WRONG if done.lost else FINE)


# --- files that are away --------------------------------------------------------------------------


@app.command()
def adopt(data: Data = None, database_url: DatabaseUrl = None) -> None:
    """Let a data directory belong to a database, after one of them was replaced: both get the same id."""
    from service.cli.offline import open_store
    from service.queue import data_identity as identity

    settings = settings_of(data=data, database_url=database_url)
    with open_store(settings) as store:
        id = identity.adopt(settings, store)
    print(f"{settings.data.absolute()} and its database have the id {id}")


@app.command("forget-lost")
def forget_lost(
    count: Annotated[
        int, typer.Argument(metavar="COUNT", min=0, help="Results, as the service says.")
    ],
    data: Data = None,
    database_url: DatabaseUrl = None,
) -> None:
    """Let so many lost results be computed again, beyond what the service forgets by itself; 0 takes it back."""
    from service.cli.offline import open_store

    with open_store(settings_of(data=data, database_url=database_url)) as store:
        store.allow_forgetting(count)
    print(
        f"{count} lost results may be forgotten; a service that waits for them looks within a minute"
    )


# --- remeasure ------------------------------------------------------------------------------------


@app.command()
def remeasure(
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Only say what would be read again.")
    ] = False,
    data: Data = None,
    database_url: DatabaseUrl = None,
) -> None:
    """Read measurements whose definition has changed off the stored final states; first stop the service."""
    from service.cli.console import print_plan, print_renewed, tracking
    from service.cli.offline import open_store, without_services
    from service.cli.remeasuring import Renewal, plan_of, renew

    settings = settings_of(data=data, database_url=database_url)
    done: list[Renewal] = []
    with (
        open_store(settings) as store,
        nullcontext() if dry_run else without_services(settings, store),
    ):
        plan = plan_of(store)
        print_plan(plan)
        if dry_run or not plan.read:
            return
        try:
            done.extend(tracking(renew(settings, store, plan.read), len(plan.read)))
        finally:  # also of a part
            print_renewed(done, plan.sweeps)
    raise typer.Exit(SOME_FAILED if any(one.reason for one in done) else FINE)


# --- small things ---------------------------------------------------------------------------------


def _scopes(words: list[str]) -> "list[Scope]":
    from service.records.jobs import Scope

    unknown = [word for word in words if word not in list(Scope)]
    if unknown:
        limit = " or ".join(Scope)
        raise InvalidInput([Finding("--scope", unknown[0], limit, "write one of these")])
    return [Scope(word) for word in words]


def _name(name: str) -> str:
    """The name of a key; raises InvalidInput for one that cannot be told from none."""
    if not name.strip() or not name.isprintable():
        raise InvalidInput([Finding("NAME", repr(name), "a name that can be read", "write one")])
    return name.strip()


def _span(text: str | None) -> "timedelta | None":
    from datetime import timedelta

    if text is None:
        return None
    match = SPAN.fullmatch(text)
    if match is None or not int(match[1]):
        raise InvalidInput([Finding("--expires", text, "a time span", "write it like 90d or 12h")])
    return timedelta(**{UNITS[match[2]]: int(match[1])})


def _meant(given: str, known: "tuple[KeyRow, ...]") -> "KeyRow":
    """The one key that is meant; raises InvalidInput."""
    found = [row for row in known if given in (row.id, row.prefix)]
    if len(found) != 1:
        cure = "look with `whipple keys list`"
        limit = "the id of a key" if not found else "the id, because several begin like that"
        raise InvalidInput([Finding("KEY", given, limit, cure)])
    return found[0]
