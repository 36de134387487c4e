"""Sweeps: submit, look, cancel, try again, remove."""

from typing import Annotated, Any

from fastapi import APIRouter, Query, Request, Response

from service.api.keys import Caller, Submitter
from service.api.queue_schemas import Change
from service.api.routes.given import (
    ArtifactsGiven,
    ChangeGiven,
    Cursor,
    Limit,
    SettingsGiven,
    StoreGiven,
    SubmissionGiven,
    SweepGiven,
    SweepId,
    check_directory,
)
from service.api.routes.links import OF_A_RUN, OF_A_SWEEP, links
from service.api.routes.pagination import link_next
from service.api.schemas import (
    EstimateModel,
    PointPage,
    PresetModel,
    SweepModel,
    SweepPage,
    example_sweeps,
)
from service.queue.garbage_collection import forget_lost_states
from service.records.jobs import RUN_STATES, State, SweepState, SweepStatus
from service.store import Store
from studies.runs.run import estimate
from studies.sweeps.cost import presets_of

router = APIRouter(prefix="/v1/sweeps", tags=["sweeps"])

RETRY_AFTER = "2"  # s; a good moment to look at a new sweep again
SWEEP_BODY: dict[str, Any] = {
    "requestBody": {
        "required": True,
        "description": (
            "A sweep document. Quantities carry their unit: `6 km/s`, `2 mm`. `resolution` may be a "
            "list and `offsets` a number of sub-cell positions; `accuracy` sets both by a name."
        ),
        "content": {
            "application/json": {"schema": {"type": "object"}, "examples": example_sweeps()},
            "application/yaml": {"schema": {"type": "object"}},
        },
    }
}
CHANGE_BODY: dict[str, Any] = {
    "requestBody": {
        "required": True,
        "content": {"application/json": {"schema": Change.model_json_schema()}},
    }
}
ByState = Annotated[
    SweepState | None,
    Query(description="only these: " + ", ".join(f"`{one}`" for one in SweepState)),
]
ByRunState = Annotated[
    State | None, Query(description="only these: " + ", ".join(f"`{one}`" for one in RUN_STATES))
]


@router.post(
    "",
    status_code=202,
    openapi_extra=SWEEP_BODY,
    responses={202: links(OF_A_SWEEP, id="$response.body#/id")},
)
def submit_sweep(asked: SubmissionGiven, store: StoreGiven, response: Response) -> SweepModel:
    """Accept a sweep. When this is answered, the sweep is on disk and will be computed.

    `reused` of the `planned` runs are computed already, or under way for another sweep; `new` ones were
    put into the queue. What was sent twice with the same `Idempotency-Key` is accepted once.
    """
    row = store.create_sweep(asked)
    accepted = SweepModel.of(row)
    response.headers["Location"] = accepted.links["self"]
    response.headers["Retry-After"] = RETRY_AFTER
    return accepted


@router.post("/estimate", openapi_extra=SWEEP_BODY)
def estimate_sweep(
    sweep: SweepGiven, store: StoreGiven, settings: SettingsGiven, request: Request
) -> EstimateModel:
    """What a sweep would cost, as it is and at each `accuracy`. Nothing is stored.

    Times are those that this service measured for runs of the same scenario, where there are any.
    """
    points = sweep.runs()
    runs = {point.run.id: point.run for point in points}
    known = store.known_runs(runs)
    estimates = [estimate(run) for id, run in runs.items() if id not in known]
    measured = store.measured_rate(sweep.scenario)
    pace = 1.0 if measured is None else measured
    core_seconds = sum(one.core_seconds for one in estimates) * pace
    workers = request.app.state.engine.workers() or settings.workers
    return EstimateModel(
        runs=len(points),
        reused=len(known),
        core_seconds=core_seconds,
        seconds=core_seconds / max(1, min(workers, len(estimates))),
        bytes=sum(one.bytes for one in estimates),
        is_measured=measured is not None,
        presets=[PresetModel.of(one, pace) for one in presets_of(sweep, settings.max_runs)],
    )


@router.get("")
def list_sweeps(
    store: StoreGiven,
    request: Request,
    response: Response,
    state: ByState = None,
    cursor: Cursor = None,
    limit: Limit = 50,
) -> SweepPage:
    """Sweeps, the youngest first."""
    page = store.sweeps(state=state, cursor=cursor, limit=limit)
    link_next(request, response, page.next_cursor)
    return SweepPage.of(page)


@router.get("/{id}")
def show_sweep(id: SweepId, store: StoreGiven) -> SweepModel:
    """A sweep: state, points by state, progress, time left, and links to what there is."""
    return SweepModel.of(*store.sweep_and_files(id))


@router.get("/{id}/document")
def show_document(id: SweepId, store: StoreGiven) -> dict[str, Any]:
    """The document of a sweep in its canonical form: it can be submitted again."""
    return dict(store.sweep_document(id))


@router.get(
    "/{id}/runs",
    responses={200: links(OF_A_RUN, id="$response.body#/items/0/run/id")},
)
def list_runs(
    id: SweepId,
    store: StoreGiven,
    request: Request,
    response: Response,
    state: ByRunState = None,
    cursor: Cursor = None,
    limit: Limit = 100,
) -> PointPage:
    """The points of a sweep in its own order, each with its run; for instance `?state=failed`."""
    page = store.sweep_runs(id, state=state, cursor=cursor, limit=limit)
    link_next(request, response, page.next_cursor)
    return PointPage.of(page)


@router.patch("/{id}", openapi_extra=CHANGE_BODY)
def change_sweep(
    id: SweepId, caller: Submitter, change: ChangeGiven, store: StoreGiven
) -> SweepModel:
    """Give a sweep another priority; runs that are under way go on."""
    _own(store, caller, id)
    return SweepModel.of(store.set_priority(id, change.priority))


@router.post("/{id}/cancel", status_code=202)
def cancel_sweep(id: SweepId, caller: Submitter, store: StoreGiven) -> SweepModel:
    """Stop. What was computed until now is published; a run that another sweep wants goes on."""
    _own(store, caller, id)
    return SweepModel.of(store.cancel_sweep(id))


@router.post("/{id}/retry", status_code=202)
def retry_sweep(
    id: SweepId,
    caller: Submitter,
    store: StoreGiven,
    settings: SettingsGiven,
    artifacts: ArtifactsGiven,
    verdicts: Annotated[
        bool, Query(description="also runs that the solver itself gave up; they will fail again")
    ] = False,
) -> SweepModel:
    """Compute again what an accident or a cancel ended, and what the disk has lost; then publish again."""
    _own(store, caller, id)
    check_directory(settings, store)
    forget_lost_states(store, artifacts, id)
    return SweepModel.of(store.retry_sweep(id, verdicts=verdicts))


@router.delete("/{id}", status_code=204)
def delete_sweep(id: SweepId, caller: Submitter, store: StoreGiven) -> None:
    """Forget a sweep that has ended, with its cube and report. Its runs stay, for other sweeps."""
    _own(store, caller, id)
    store.delete_sweep(id)


def _own(store: Store, caller: Caller, id: str) -> SweepStatus:
    """The sweep, if the caller may give orders about it; raises NotFound, NotAllowed."""
    row = store.sweep(id)
    caller.check_owns(row)
    return row
