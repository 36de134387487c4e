"""The list of sweeps: a logbook with the headline and the figure of each, in an order and with filters."""

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Literal
from urllib.parse import urlencode

from fastapi import APIRouter, Query, Request, Response

from service.api.access import Reader
from service.api.dependencies import AppStore
from service.api.schemas import SweepModel
from service.pages.covers import cover_address
from service.pages.differing import in_words, told_apart
from service.pages.page_routes import PageRoutes
from service.pages.rendering import LONGEST_TEXT, MOST_PLACE, page
from service.records.jobs import SweepState
from service.records.logbook import PAGE as USUAL
from service.records.logbook import Column, LogbookEntry, Wanted
from studies import materials, scenarios
from studies.quantities.files import COVER
from studies.quantities.parameters import Plain
from studies.reports.cover import THUMBNAIL

router = APIRouter(include_in_schema=False)
PAGE = PageRoutes("listing", 10, router, (("/", "Sweeps"),))

MOST_LISTED = 500  # sweeps of a page
COLUMNS: Mapping[Column, str] = {
    "title": "Sweep",
    "scenario": "Scenario",
    "materials": "Materials",
    "runs": "Runs",
    "submitted": "Submitted",
}


@dataclass(frozen=True)
class ListedSweep:
    """A row of the list."""

    sweep: SweepModel
    materials: tuple[str, ...]
    axes: str  # in words
    apart: str  # in what it differs from the others of its title; empty where its title is its own
    is_alike: bool  # whether another row has its title
    thumbnail: str  # address; empty where there is none


def _listed(entry: LogbookEntry, apart: Mapping[str, str]) -> ListedSweep:
    status = entry.status
    axes = "; ".join(f"{name.replace('_', ' ')} {in_words(values)}" for name, values in entry.axes.items())
    thumbnail = cover_address(status, THUMBNAIL) if COVER in entry.files else ""
    sweep = SweepModel.of(status, entry.files)
    return ListedSweep(sweep, entry.materials, axes, apart.get(status.id, ""), status.id in apart, thumbnail)


def _apart(entries: Sequence[LogbookEntry]) -> dict[str, str]:
    """By id, in what the sweeps of one title differ."""
    titled = defaultdict[str, dict[str, Mapping[str, Plain]]](dict)
    for entry in entries:
        titled[entry.status.title][entry.status.id] = entry.document or {}
    return {id: words for alike in titled.values() if len(alike) > 1 for id, words in told_apart(alike).items()}


@router.get("/")
def show_sweeps(
    request: Request,
    caller: Reader,
    store: AppStore,
    q: Annotated[str, Query(max_length=LONGEST_TEXT)] = "",
    state: Annotated[SweepState | Literal[""], Query()] = "",
    scenario: Annotated[str, Query(max_length=LONGEST_TEXT)] = "",
    material: Annotated[str, Query(max_length=LONGEST_TEXT)] = "",
    own: Annotated[bool, Query()] = False,
    order: Annotated[Column, Query()] = "submitted",
    up: Annotated[bool, Query()] = False,
    first: Annotated[int, Query(ge=0, le=MOST_PLACE)] = 0,
    show: Annotated[int, Query(ge=1, le=MOST_LISTED)] = USUAL,
) -> Response:
    """The sweeps with headline, figure, materials and size, and links to their pages, reports and cubes."""
    wanted = Wanted(
        text=q.strip(),
        state=SweepState(state) if state else None,
        scenario=scenario,
        material=material.strip(),
        owner=caller.name if own else None,
        order=order,
        ascending=up,
        first=first,
        limit=show,
    )
    log = store.sweeps.logbook(wanted)
    chosen = {"q": q, "state": str(state), "scenario": scenario, "material": material, "own": "true" * own}
    asked = {name: text for name, text in chosen.items() if text}
    kept = asked | ({} if show == USUAL else {"show": str(show)})
    ordered = kept | ({} if order == "submitted" and not up else {"order": order, "up": str(up).lower()})

    def link(**changes: str | int) -> str:
        return "/?" + urlencode({**ordered, **changes})

    apart = _apart(log.entries)
    return page(
        request,
        "sweeps.html",
        caller,
        rows=[_listed(entry, apart) for entry in log.entries],
        next=link(first=first + show) if log.has_more else "",
        previous=link(first=max(0, first - show)) if first else "",
        asked=asked,
        kept=kept,
        columns=COLUMNS,
        order=order,
        up=up,
        states=list(SweepState),
        scenarios=scenarios.names(),
        materials=materials.names(),
        queue=log,
        events="/v1/queue/events",
    )
