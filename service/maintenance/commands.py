"""The maintenance of database and files: checks, backup, retention, measuring again."""

import sys
from collections.abc import Sequence
from contextlib import nullcontext, suppress
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from service.cli.commands import SERVICE, Commands
from service.cli.console import SHORT_ID, moment, print_json, print_table, say
from service.cli.options import FAILURE, SOME_FAILED, SUCCESS, Data, Json, settings_of
from service.maintenance.keys import duration_of
from service.maintenance.offline import DatabaseUrl, open_store, record_command, without_services
from studies.quantities.findings import refusal

if TYPE_CHECKING:
    from service.settings import Settings

app = typer.Typer()
COMMANDS = Commands("maintenance", SERVICE, app, place=1)

MOST_LINES = 20  # printed lines of a list of results or files


@app.command()
def doctor(
    adopt: Annotated[
        bool, typer.Option("--adopt", help="Assign data directory and database to each other, after one was replaced.")
    ] = False,
    forget_lost: Annotated[
        int | None,
        typer.Option(min=0, metavar="COUNT", help="Let so many lost results be computed again, beyond the limit."),
    ] = None,
    trust_clock: Annotated[
        bool, typer.Option("--trust-clock", help="Say that the clock is right: the service deletes by age again.")
    ] = False,
    remeasure: Annotated[
        bool,
        typer.Option(
            "--remeasure",
            help="Apply changed definitions of measurements to the stored final states; stop the service first.",
        ),
    ] = False,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="With --remeasure: only list the results.")] = False,
    as_json: Json = False,
    data: Data = None,
    database_url: DatabaseUrl = None,
) -> None:
    """Check data directory, database and workers, and print cures, of which options are some.

    The exit status is 1 on an error.
    """
    settings = settings_of(data=data, database_url=database_url)
    if adopt or trust_clock or remeasure or forget_lost is not None:
        if as_json:
            raise refusal("--json", "--json", "a check without a cure", "leave it out")
        _cure(settings, forget_lost, adopt=adopt, trust_clock=trust_clock)
        if remeasure:
            _remeasure(settings, dry_run=dry_run)
        return
    from service.maintenance.doctor import CheckStatus, examine

    checks = []
    for check in examine(settings):
        checks.append(check)
        if not as_json:
            cure = f"\n{'':8} -> {check.cure}" if check.cure else ""
            say(f"{check.status.upper():<8} {check.name}: {check.detail}{cure}", flush=True)
    if as_json:
        print_json([vars(check) for check in checks])
    errors = sum(check.status is CheckStatus.ERROR for check in checks)
    raise typer.Exit(FAILURE if errors else SUCCESS)


def _cure(settings: "Settings", forget_lost: int | None, *, adopt: bool, trust_clock: bool) -> None:
    """Change what the store holds about the clock, lost results, or its data directory."""
    if not (adopt or trust_clock or forget_lost is not None):
        return
    from service.queue import data_identity as identity

    with open_store(settings) as store:
        if adopt:
            id = identity.adopt(settings, store)
            record_command(store, "adopt")
            print(f"{settings.data.absolute()} and its database have the id {id}")
        if trust_clock:
            store.retention.trust_clock()
            record_command(store, "trust clock")
            print("the clock is believed: the service deletes by age again")
        if forget_lost is not None:
            store.queue.allow_forgetting(forget_lost)
            record_command(store, "forget lost")
            print(f"{forget_lost} lost results may be computed again; the service starts them within a minute")


@app.command()
def backup(
    out: Annotated[Path, typer.Argument(metavar="OUT", help="Folder; an earlier backup there is updated.")],
    data: Data = None,
) -> None:
    """Copy database and files (SQLite) while the service runs. OUT then is a data directory."""
    from service.maintenance.backup import back_up

    settings = settings_of(data=data)
    with open_store(settings) as store:
        done = back_up(settings, out, store)
    say(f"{done.folder}: {done.copied} files copied ({done.size / 1e6:.1f} MB), {done.present} present")
    if done.removed:
        say(f"  {done.removed} files were deleted by the service meanwhile and are left out")
    for path in done.lost[:MOST_LINES]:
        say(f"  lost or damaged: {path}", file=sys.stderr)
    if done.lost:
        say(f"  {len(done.lost)} files are missing; see `whipple doctor`", file=sys.stderr)
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
    as_json: Json = False,
    data: Data = None,
    database_url: DatabaseUrl = None,
) -> None:
    """List, or delete, ended sweeps by age, size and owner; pinned ones stay, and runs that another sweep has."""
    from service.records.jobs import Conflict, NotFound

    if older_than is None and to_size is None and owner is None:
        raise refusal("retention", "no rule", "--older-than, --to-size or --owner", "give one of them")
    before = datetime.now(UTC) - (timedelta() if older_than is None else duration_of("--older-than", older_than))
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
        rows = (
            (sweep.id[:SHORT_ID], moment(sweep.finished), f"{sweep.size / 1e6:.1f} MB", sweep.owner, sweep.name)
            for sweep in expired.values()
        )
        print_table(("id", "ended (UTC)", "size", "owner", "name"), rows)
        say(f"{len(expired)} sweeps, {sum(sweep.size for sweep in expired.values()) / 1e6:.1f} MB")
    if not apply:
        print("nothing was deleted: --apply deletes them", file=sys.stderr)


def _size(option: str, text: str) -> int:
    """The bytes that an option gives; raises InvalidInput."""
    from pydantic import ByteSize, TypeAdapter, ValidationError

    try:
        return TypeAdapter(ByteSize).validate_python(text)
    except ValidationError:
        raise refusal(option, text, "a size", "write it like 500GB or 2TiB") from None


def _remeasure(settings: "Settings", *, dry_run: bool) -> None:
    """Read the stored final states again, by the definitions of measurements that changed."""
    from rich.console import Console
    from rich.progress import track

    from service.maintenance.remeasuring import Remeasured, plan_of, remeasure_runs

    terminal = Console(stderr=True)
    done: list[Remeasured] = []
    with open_store(settings) as store, nullcontext() if dry_run else without_services(settings, store):
        plan = plan_of(store)
        count, lost = len(plan.measurable), len(plan.without_state)
        say(f"to measure again: {count} results of {len(plan.sweeps)} sweeps; without a stored final state: {lost}")
        _print_unchanged([(id, "its final state was not kept") for id in plan.without_state])
        if dry_run or not plan.measurable:
            return
        record_command(store, "remeasure")
        try:
            measured = remeasure_runs(settings, store, plan.measurable)
            done.extend(track(measured, "results", total=count, console=terminal, disable=not terminal.is_terminal))
        finally:
            # Also after an interruption.
            failed = [(result.run_id, result.reason) for result in done if result.reason]
            say(f"changed: {len(done) - len(failed)} results; unreadable: {len(failed)}")
            _print_unchanged(failed)
            marked = {id: plan.sweeps[id] for result in done for id in result.marked}
            say(f"published again at the next start of the service: {len(marked)} sweeps")
            for id, name in marked.items():
                say(f"  {id}  {name}")
    raise typer.Exit(SOME_FAILED if failed else SUCCESS)


def _print_unchanged(results: Sequence[tuple[str, str]]) -> None:
    """The first results that stay as they are, with the reasons, and the number of the others."""
    for id, reason in results[:MOST_LINES]:
        say(f"  {id} is unchanged: {reason}")
    if len(results) > MOST_LINES:
        say(f"  ... and {len(results) - MOST_LINES} more")
