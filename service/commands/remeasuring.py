"""``whipple remeasure`` on a store: say what is outdated, order it, and see to it that it is done."""

import time
from collections.abc import Sequence
from dataclasses import asdict

from service import remeasuring
from service.console import in_words, print_plan
from service.jobs import Conflict, SweepRow, SweepState
from service.settings import Settings
from service.store import Store
from service.unattended import publish_what_waits

LOOK_SECONDS = 0.5  # between two looks at what a service does
SWEEPS_ON_A_PAGE = 500


def remeasure_here(
    settings: Settings, store: Store, ids: Sequence[str] | None, *, dry_run: bool
) -> bool:
    """Whether all that could be read again was; with ``dry_run`` it is only told."""
    sweeps = [store.sweep(id) for id in ids] if ids else _all(store)
    before = store.last_event()
    outdated = [row for row in sweeps if _is_outdated(store, row)]
    if not outdated:
        print("nothing is to be read again")
    if dry_run:
        return True
    ordered = [row for row in outdated if _is_ordered(store, row)]
    if ordered and not publish_what_waits(settings, store):
        print("a service works here, and does it", flush=True)
        _wait(settings, store, ordered)
    told = [_is_told(store, row, before) for row in ordered]  # each, whatever the others are
    return all(told) and len(ordered) == len(outdated)


def _is_outdated(store: Store, row: SweepRow) -> bool:
    """Whether there is something to read again of a sweep; says what, and what was not kept."""
    plan = remeasuring.plan_of(store, row.id)
    if not plan.read and not plan.not_kept:
        return False
    counts = {**asdict(plan), "remeasured": len(plan.read), "not_kept": len(plan.not_kept)}
    print_plan(f"{row.id}  {row.name}", counts, plan.not_kept)
    return bool(plan.read)


def _is_ordered(store: Store, row: SweepRow) -> bool:
    """Whether it could be ordered, now or before; not while the sweep is computed."""
    try:
        remeasuring.order(store, row.id)
    except Conflict as error:
        print(f"{row.id}  {row.name}: {error}")
        return False
    return True


def _is_told(store: Store, row: SweepRow, before: int) -> bool:
    """Say what came of a sweep; whether that is all that was asked."""
    now = store.sweep(row.id)
    print(f"{row.id}  {row.name}: {now.state} ({in_words(now.counts)})")
    if now.reason:
        print(f"  {now.reason}")
    told = [one for one in store.events(row.id, after=before) if one.kind == "remeasured"]
    unreadable = {
        id: reason
        for one in told
        if one.sweep_id == row.id
        for id, reason in one.body["unreadable"].items()
    }
    for id, reason in unreadable.items():
        print(f"  {id} stays as it was: {reason}")
    return now.state is not SweepState.FAILED and not unreadable


def _wait(settings: Settings, store: Store, ordered: Sequence[SweepRow]) -> None:
    """Until a service has done it, or is gone and it is done here; Ctrl-C leaves it at its work."""
    while not all(store.sweep(row.id).is_terminal for row in ordered):
        if publish_what_waits(settings, store):
            return
        time.sleep(LOOK_SECONDS)


def _all(store: Store) -> list[SweepRow]:
    found: list[SweepRow] = []
    cursor: str | None = None
    while True:
        page = store.sweeps(cursor=cursor, limit=SWEEPS_ON_A_PAGE)
        found.extend(page.items)
        cursor = page.next_cursor
        if cursor is None:
            return found
