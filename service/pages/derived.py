"""Sweeps that a page makes of a stored one: with further values on an axis, or of one of its runs with its film."""

from collections.abc import AsyncIterator, Mapping
from typing import Annotated, Any

from fastapi import Depends, Request

from service.api.access import Submitter
from service.api.browsers import FormFields, idempotency_of
from service.api.dependencies import AppSettings, AppStore, RunId, SweepId, read_content, submission_of, submitting
from service.api.reading import alone, longer
from service.records.jobs import USUAL_PRIORITIES, Conflict, Keep, Scope, Submission, SweepStatus

MOST_PLACES = 10  # sweeps of a run that are looked at
FILM_OF = "Film of a run of "  # the title of a film begins so


def _stored(id: SweepId, store: AppStore) -> tuple[SweepStatus, Mapping[str, Any]]:
    """A sweep and its document; raises NotFound."""
    return store.sweeps.get(id), store.sweeps.document(id)


def _of_run(id: RunId, store: AppStore) -> dict[str, Any]:
    """A run in one of its sweeps, as ``reading.alone`` takes it; raises NotFound, Conflict."""
    run = store.runs.get(id)
    place = next((each for each in store.runs.places(id, MOST_PLACES) if "screening" not in each.coordinates), None)
    if place is None:
        raise Conflict("no sweep has this run at a point of its axes any more; submit one that does")
    title = f"{FILM_OF}{place.title.removeprefix(FILM_OF)}"[:200]
    return {"sweep": store.sweeps.document(place.sweep_id), "at": place.coordinates, "run": run.id, "title": title}


async def _longer(
    request: Request,
    caller: Submitter,
    form: FormFields,
    settings: AppSettings,
    stored: Annotated[tuple[SweepStatus, Mapping[str, Any]], Depends(_stored)],
) -> AsyncIterator[Submission]:
    """A sweep with the values of a form on one of its axes; raises InvalidInput."""
    status, document = stored
    change = {"sweep": document, "axis": form.get("axis", ""), "values": form.get("values", "")}
    once = idempotency_of(form, status.id, form.get("axis"), form.get("values"))
    priority = status.priority if caller.may(Scope.ADMIN) else max(status.priority, USUAL_PRIORITIES[0])
    async with submitting(request):
        sweep = await read_content(request, change, longer)
        yield submission_of(settings, caller, sweep, priority, status.keep, once)


async def _filmed(
    request: Request, caller: Submitter, settings: AppSettings, run: Annotated[dict[str, Any], Depends(_of_run)]
) -> AsyncIterator[Submission]:
    """A sweep of a single run that keeps its film and its final state; raises InvalidInput."""
    async with submitting(request):
        sweep = await read_content(request, run, alone)
        yield submission_of(settings, caller, sweep, keep=Keep.FILM)


LongerSweep = Annotated[Submission, Depends(_longer, scope="function")]
FilmedRun = Annotated[Submission, Depends(_filmed, scope="function")]
