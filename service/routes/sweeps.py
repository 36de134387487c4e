"""Sweeps: submit, look, cancel, try again, remove."""

from typing import Annotated, Any

from fastapi import APIRouter, Path, Query, Response

from service.jobs import RUN_STATES, State, SweepState
from service.routes.given import SettingsGiven, StoreGiven, SweepGiven
from service.schemas import (
    EstimateModel,
    PointPage,
    PresetModel,
    SweepModel,
    SweepPage,
    example_sweeps,
)
from studies.cost import presets_of
from studies.run import estimate

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
Cursor = Annotated[str | None, Query(description="`next_cursor` of the page before")]
SweepId = Annotated[str, Path(description="what the answer to the submission said")]
ByState = Annotated[
    SweepState | None,
    Query(description="only these: " + ", ".join(f"`{one}`" for one in SweepState)),
]
ByRunState = Annotated[
    State | None, Query(description="only these: " + ", ".join(f"`{one}`" for one in RUN_STATES))
]
Limit = Annotated[int, Query(ge=1, le=1000, description="items on a page")]


@router.post("", status_code=202, openapi_extra=SWEEP_BODY)
def submit_sweep(sweep: SweepGiven, store: StoreGiven, response: Response) -> SweepModel:
    """Accept a sweep. When this is answered, the sweep is on disk and will be computed."""
    accepted = SweepModel.of(store.create_sweep(sweep))
    response.headers["Location"] = accepted.links["self"]
    response.headers["Retry-After"] = RETRY_AFTER
    return accepted


@router.post("/estimate", openapi_extra=SWEEP_BODY)
def estimate_sweep(sweep: SweepGiven, store: StoreGiven, settings: SettingsGiven) -> EstimateModel:
    """What a sweep would cost, as it is and at each `accuracy`. Nothing is stored."""
    points = sweep.runs()
    runs = {point.run.id: point.run for point in points}
    known = store.known_runs(runs)
    estimates = [estimate(run) for id, run in runs.items() if id not in known]
    pace = store.pace() or 1.0
    core_seconds = sum(one.core_seconds for one in estimates) * pace
    return EstimateModel(
        runs=len(points),
        reused=len(known),
        core_seconds=core_seconds,
        seconds=core_seconds / max(1, min(settings.workers, len(estimates))),
        bytes=sum(one.bytes for one in estimates),
        presets=[PresetModel.of(one, pace) for one in presets_of(sweep, settings.max_runs)],
    )


@router.get("")
def list_sweeps(
    store: StoreGiven, state: ByState = None, cursor: Cursor = None, limit: Limit = 50
) -> SweepPage:
    """Sweeps, the youngest first."""
    return SweepPage.of(store.sweeps(state=state, cursor=cursor, limit=limit))


@router.get("/{id}")
def show_sweep(id: SweepId, store: StoreGiven) -> SweepModel:
    """A sweep: state, points by state, progress, time left, and links to what there is."""
    return SweepModel.of(store.sweep(id), [file.name for file in store.artifacts(id)])


@router.get("/{id}/document")
def show_document(id: SweepId, store: StoreGiven) -> dict[str, Any]:
    """The document of a sweep in its canonical form: it can be submitted again."""
    return dict(store.sweep_document(id))


@router.get("/{id}/runs")
def list_runs(
    id: SweepId,
    store: StoreGiven,
    state: ByRunState = None,
    cursor: Cursor = None,
    limit: Limit = 100,
) -> PointPage:
    """The points of a sweep in its own order, each with its run; for instance `?state=failed`."""
    return PointPage.of(store.sweep_runs(id, state=state, cursor=cursor, limit=limit))


@router.post("/{id}/cancel", status_code=202)
def cancel_sweep(id: SweepId, store: StoreGiven) -> SweepModel:
    """Stop. What was computed until now is published; a run that another sweep wants goes on."""
    return SweepModel.of(store.cancel_sweep(id))


@router.post("/{id}/retry", status_code=202)
def retry_sweep(
    id: SweepId,
    store: StoreGiven,
    verdicts: Annotated[
        bool, Query(description="also runs that the solver itself gave up; they will fail again")
    ] = False,
) -> SweepModel:
    """Compute again what an accident or a cancel ended, then publish again."""
    return SweepModel.of(store.retry_sweep(id, verdicts=verdicts))


@router.delete("/{id}", status_code=204)
def delete_sweep(id: SweepId, store: StoreGiven) -> None:
    """Forget a sweep that has ended, with its cube and report. Its runs stay, for other sweeps."""
    store.delete_sweep(id)
