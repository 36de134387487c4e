"""Sweeps: submit, show, change, cancel, retry, delete."""

from dataclasses import replace
from typing import Annotated

from fastapi import APIRouter, Query, Request, Response
from pydantic import JsonValue

from service.api.access import Caller, Submitter
from service.api.dependencies import (
    AppArtifacts,
    AppSettings,
    AppStore,
    Cursor,
    Idempotency,
    KeepQuery,
    PageLimit,
    PatchedSweep,
    PostedDocument,
    Prefix,
    Priority,
    SweepId,
    check_priority,
    in_child,
    link_next,
    submit,
    submitting,
)
from service.api.errors import Forbidden
from service.api.readiness import check_directory
from service.api.reading import expanded
from service.api.routes import Routes
from service.api.schemas import (
    COMPONENTS,
    AcceptedSweepModel,
    PageOf,
    PointModel,
    SweepChange,
    SweepModel,
    example_sweeps,
)
from service.queue.garbage_collection import forget_lost_states
from service.records.jobs import RUN_STATES, Keep, Scope, State, SweepState
from service.store import Store
from studies.quantities.parameters import Plain
from studies.sweeps.schema import SWEEP

submitting_router = APIRouter(prefix="/v1/sweeps", tags=["submit"])
router = APIRouter(prefix="/v1/sweeps", tags=["watch"])
ROUTES = Routes("sweeps", 10, guarded=(submitting_router, router))

RETRY_AFTER = "2"  # s, until a new sweep is worth another request
SWEEP_SCHEMA: dict[str, Plain] = {"schema": {"$ref": COMPONENTS + SWEEP}}
SWEEP_BODY: dict[str, Plain] = {
    "requestBody": {
        "required": True,
        "description": "A sweep document; `/v1/schema/sweep` is its schema. Quantities have a unit: `6 km/s`, `2 mm`.",
        "content": {
            "application/json": {**SWEEP_SCHEMA, "examples": example_sweeps()},
            "application/yaml": SWEEP_SCHEMA,
        },
    }
}
CHANGE_BODY: dict[str, JsonValue] = {
    "requestBody": {"required": True, "content": {"application/json": {"schema": SweepChange.model_json_schema()}}}
}
# Operations on a sweep and on a run, for programs that follow OpenAPI links.
SWEEP_LINKS = (
    *("show_sweep", "show_document", "list_runs", "change_sweep", "cancel_sweep", "retry_sweep"),
    *("delete_sweep", "list_sweep_events", "get_cube_nc", "get_runs_csv", "get_report_html"),
    "get_report_json",
)
RUN_LINKS = ("show_run", "list_files", "list_run_events", "download_log")


def _links(operations: tuple[str, ...], id: str) -> dict[str, JsonValue]:
    """OpenAPI links of a response to operations that take the ``id`` in its body."""
    return {"links": {name: {"operationId": name, "parameters": {"id": id}} for name in operations}}


@submitting_router.post(
    "", status_code=202, openapi_extra=SWEEP_BODY, responses={202: _links(SWEEP_LINKS, "$response.body#/id")}
)
async def submit_sweep(
    request: Request,
    response: Response,
    _: Submitter,
    posted: PostedDocument,
    once: Idempotency,
    priority: Priority = 0,
    keep: KeepQuery = Keep.FINAL,
) -> AcceptedSweepModel:
    """Accept a sweep. Once the response is sent, the sweep is on disk and will be computed.

    `reused` of the `planned` runs are computed already, or under way for another sweep; `new` ones were
    queued. Requests with the same `Idempotency-Key` are accepted once. `warnings` are those of the estimate.
    """
    async with submitting(request):
        sweep = await in_child(request, expanded, posted)
        status = await submit(request, sweep, priority, keep, once)
    accepted = replace(AcceptedSweepModel.of(status), warnings=sweep.warnings)
    response.headers["Location"] = accepted.links["self"]
    response.headers["Retry-After"] = RETRY_AFTER
    return accepted


@router.get("")
def list_sweeps(
    store: AppStore,
    request: Request,
    response: Response,
    state: Annotated[SweepState | None, Query(description="Sweeps in this state only")] = None,
    prefix: Prefix = "",
    cursor: Cursor = None,
    limit: PageLimit = 50,
) -> PageOf[SweepModel]:
    """Sweeps, newest first."""
    page = store.sweeps.page(state=state, prefix=prefix, cursor=cursor, limit=limit)
    link_next(request, response, page.next_cursor)
    items = [SweepModel.of(row) for row in page.items]
    return PageOf(items=items, next_cursor=page.next_cursor)


@router.get("/{id}")
def show_sweep(id: SweepId, store: AppStore) -> SweepModel:
    """A sweep: state, points by state, progress, time left, and links."""
    return SweepModel.of(*store.sweeps.get_with_files(id))


@router.get("/{id}/document")
def show_document(id: SweepId, store: AppStore) -> dict[str, JsonValue]:
    """The document of a sweep in its canonical form, which can be submitted again."""
    return dict(store.sweeps.document(id))


@router.get("/{id}/runs", responses={200: _links(RUN_LINKS, "$response.body#/items/0/run/id")})
def list_runs(
    id: SweepId,
    store: AppStore,
    request: Request,
    response: Response,
    state: Annotated[
        State | None, Query(description="Points in this state only: " + ", ".join(f"`{state}`" for state in RUN_STATES))
    ] = None,
    cursor: Cursor = None,
    limit: PageLimit = 100,
) -> PageOf[PointModel]:
    """The points of a sweep in its own order, each with its run; for example `?state=failed`."""
    page = store.sweeps.points(id, state=state, cursor=cursor, limit=limit)
    link_next(request, response, page.next_cursor)
    items = [PointModel.of(row) for row in page.items]
    return PageOf(items=items, next_cursor=page.next_cursor)


@router.patch("/{id}", openapi_extra=CHANGE_BODY)
def change_sweep(id: SweepId, caller: Submitter, change: PatchedSweep, store: AppStore) -> SweepModel:
    """Change the priority of a sweep; running runs continue."""
    _check_owner(store, caller, id)
    check_priority(caller, change.priority)
    return SweepModel.of(store.sweeps.set_priority(id, change.priority))


@router.post("/{id}/cancel", status_code=202)
def cancel_sweep(id: SweepId, caller: Submitter, store: AppStore) -> SweepModel:
    """Stop a sweep. The results so far are published; runs of other sweeps continue."""
    _check_owner(store, caller, id)
    return SweepModel.of(store.sweeps.cancel(id))


@router.post("/{id}/retry", status_code=202)
def retry_sweep(
    id: SweepId,
    caller: Submitter,
    store: AppStore,
    settings: AppSettings,
    artifacts: AppArtifacts,
    verdicts: Annotated[bool, Query(description="Also repeat runs that the solver rejected; they fail again")] = False,
) -> SweepModel:
    """Compute cancelled, failed and lost runs again, then publish again."""
    _check_owner(store, caller, id)
    check_directory(settings, store)
    forget_lost_states(store, artifacts, id)
    return SweepModel.of(store.sweeps.retry(id, verdicts=verdicts))


@router.put("/{id}/pin")
def pin_sweep(id: SweepId, caller: Submitter, store: AppStore) -> SweepModel:
    """Pin a sweep: it is not deleted, by nobody and by no rule of retention, until it is unpinned."""
    _check_owner(store, caller, id)
    return SweepModel.of(store.sweeps.pin(id, pinned=True))


@router.delete("/{id}/pin")
def unpin_sweep(id: SweepId, caller: Submitter, store: AppStore) -> SweepModel:
    """Unpin a sweep."""
    _check_owner(store, caller, id)
    return SweepModel.of(store.sweeps.pin(id, pinned=False))


@router.delete("/{id}", status_code=204)
def delete_sweep(id: SweepId, caller: Submitter, store: AppStore) -> None:
    """Delete a sweep that has ended, with its cube and report. Its runs stay available to other sweeps."""
    _check_owner(store, caller, id)
    store.sweeps.delete(id)


def _check_owner(store: Store, caller: Caller, id: str) -> None:
    """Raise NotFound, or Forbidden if the caller may not change the sweep."""
    if not caller.owns(store.sweeps.get(id)):
        raise Forbidden(
            f"the sweep was submitted with another key; ask its owner, or use a key with the scope `{Scope.ADMIN}`",
            scope=Scope.ADMIN,
        )
