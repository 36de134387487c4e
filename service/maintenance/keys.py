"""API keys of a service, and what was ordered with them."""

import re
import sys
from collections.abc import Iterable, Sequence
from datetime import UTC, datetime, timedelta
from typing import IO, TYPE_CHECKING, Annotated

import typer

from service.cli.commands import SERVICE, Commands
from service.cli.console import SHORT_ID, moment, print_json, print_table
from service.cli.options import Data, Json, settings_of
from service.maintenance.offline import DatabaseUrl, open_store, record_command
from studies.quantities.findings import refusal

if TYPE_CHECKING:
    from service.records.jobs import KeyRow

app = typer.Typer()
keys = typer.Typer(no_args_is_help=True)
app.add_typer(
    keys, name="keys", help="API keys, which requests from other machines need, and the orders that were given."
)
COMMANDS = Commands("keys", SERVICE, app, place=2)

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
    from service.records.jobs import Scope

    unknown = [word for word in scope or () if word not in list(Scope)]
    if unknown:
        raise refusal("--scope", unknown[0], " or ".join(Scope), "write one of these")
    if not name.strip() or not name.isprintable():
        raise refusal("NAME", name, "a printable name", "write a name")
    until = None if expires is None else datetime.now(UTC) + duration_of("--expires", expires)
    with open_store(settings_of(data=data, database_url=database_url), create=True) as store:
        others = sum(key.name == name.strip() for key in store.keys.all())
        row, secret = store.keys.issue(name.strip(), [*map(Scope, scope or ("submit",))], until)
        _print_secret(row, secret)
        if others:
            count = "another key is" if others == 1 else f"{others} other keys are"
            print(
                f"{count} named {row.name}: they share their sweeps and quotas, and each may cancel and delete them "
                "all; for an owner apart revoke this one, and choose another name",
                file=sys.stderr,
            )
        record_command(store, "key created", row.id)


@keys.command("rotate")
def rotate_key(
    key: KeyArgument,
    grace: Annotated[str, typer.Option(help="How long the old secret is still valid, such as 7d, 12h or 30m.")] = "7d",
    data: Data = None,
    database_url: DatabaseUrl = None,
) -> None:
    """Replace a key by one of the same name, scopes and lifetime, and print its secret once; the old one ends later."""
    with open_store(settings_of(data=data, database_url=database_url)) as store:
        old = _matching(key, store.keys.all())
        _print_secret(*store.keys.rotate(old, duration_of("--grace", grace)))
        record_command(store, "key rotated", old.id)


def _print_keys(rows: "Iterable[KeyRow]", *, file: IO[str] | None = None) -> None:
    """A table of keys without their secrets."""
    columns = ("id", "secret", "name", "scopes", "state", "expires (UTC)", "used (UTC)")
    lines = (
        (
            *(key.id[:SHORT_ID], f"{key.prefix}...", key.name, " ".join(sorted(key.scopes))),
            *("revoked" if key.revoked else "", moment(key.expires) or "never", moment(key.used) or "never"),
        )
        for key in rows
    )
    print_table(columns, lines, file=file)


def _print_secret(row: "KeyRow", secret: str) -> None:
    print(secret)
    _print_keys([row], file=sys.stderr)
    print("save the secret: it cannot be shown again", file=sys.stderr)


@keys.command("list")
def list_keys(as_json: Json = False, data: Data = None, database_url: DatabaseUrl = None) -> None:
    """List all keys, without their secrets."""
    with open_store(settings_of(data=data, database_url=database_url)) as store:
        rows = store.keys.all()
    print_json([vars(row) for row in rows]) if as_json else _print_keys(rows)


@keys.command("revoke")
def revoke_key(key: KeyArgument, data: Data = None, database_url: DatabaseUrl = None) -> None:
    """Revoke a key, from the next request on."""
    with open_store(settings_of(data=data, database_url=database_url)) as store:
        revoked = store.keys.revoke(_matching(key, store.keys.all()).id)
        _print_keys([revoked])
        record_command(store, "key revoked", revoked.id)


@keys.command("audit")
def audit(
    since: Annotated[datetime | None, typer.Option(help="First time, in UTC.")] = None,
    owner: Annotated[str | None, typer.Option(help="Name of a key, or of a user of the service's machine.")] = None,
    action: Annotated[str | None, typer.Option(help="Such as submit, cancel, or `refused key`.")] = None,
    as_json: Json = False,
    data: Data = None,
    database_url: DatabaseUrl = None,
) -> None:
    """List the orders that the service was given: who, from where, and what came of it; oldest first."""
    with open_store(settings_of(data=data, database_url=database_url)) as store:
        entries = store.audit.entries((since or datetime.min).replace(tzinfo=UTC), owner=owner, action=action)
    if as_json:
        print_json([vars(entry) for entry in entries])
        return
    rows = (
        (
            *(f"{entry.time:%Y-%m-%d %H:%M:%S}", entry.owner, (entry.key_id or "")[:SHORT_ID], entry.address),
            *(entry.action, entry.subject[:SHORT_ID], entry.outcome),
        )
        for entry in entries
    )
    print_table(("time (UTC)", "owner", "key", "from", "action", "subject", "outcome"), rows)


def duration_of(option: str, text: str) -> timedelta:
    """The duration that an option gives; raises InvalidInput."""
    match = DURATION.fullmatch(text)
    if match is None:
        limit = "a whole number of days (d), hours (h) or minutes (m), at least 1m"
        raise refusal(option, text, limit, "write it like 90d, 12h or 30m")
    return timedelta(**{UNITS[match[2]]: int(match[1])})


def _matching(text: str, rows: "Sequence[KeyRow]") -> "KeyRow":
    """The one key whose id or secret begins so, or the usable one of a name; raises InvalidInput."""
    moment = datetime.now(UTC)
    matching = [row for row in rows if text and (row.id.startswith(text) or text == row.prefix)]
    matching = matching or [row for row in rows if row.name == text and row.is_usable(moment)]
    if len(matching) != 1:
        candidates = ", ".join(f"{row.id[:SHORT_ID]} ({row.name})" for row in matching)
        limit = "the beginning of one id" if matching else "the id of a key"
        raise refusal("KEY", text, limit, f"write more of it: {candidates}" if matching else "see `whipple keys list`")
    return matching[0]
