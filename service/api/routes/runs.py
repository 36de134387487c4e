"""Runs: one simulation each, with its log and its files."""

from pathlib import Path as FilePath
from typing import Annotated

from fastapi import APIRouter, Path, Request, Response
from fastapi.responses import FileResponse
from pydantic_core import to_jsonable_python
from starlette.concurrency import run_in_threadpool

from service.api.dependencies import AppArtifacts, AppStore, PageLimit, Prefix, RunId
from service.api.downloads import Download, media_type_of, send_file, serves
from service.api.routes import Routes
from service.api.schemas import FileModel, Items, RunModel, RunQuestion
from service.files.artifacts import LOG, OF_A_RUN, Artifacts
from service.records.jobs import NotFound, State, Stored
from service.store import Store

router = APIRouter(prefix="/v1/runs", tags=["runs"])
ROUTES = Routes("runs", 30, guarded=(router,))


@router.get("")
def list_runs_by_id(store: AppStore, prefix: Prefix = "", limit: PageLimit = 50) -> Items[RunModel]:
    """Runs of all sweeps whose ids begin with some digits, in the order of their ids."""
    return Items(items=[RunModel.of(row) for row in store.runs.with_prefix(prefix, limit)])


@router.get("/{id}")
def show_run(id: RunId, store: AppStore) -> RunQuestion:
    """A run: its complete parameters, its state and its measurements."""
    run = RunModel.of(store.runs.get(id))
    return RunQuestion(**vars(run), question=to_jsonable_python(store.runs.spec(id)))


@router.get("/{id}/files")
def list_files(id: RunId, store: AppStore) -> Items[FileModel]:
    """The stored files of a run, as the retention of its sweeps asks for."""
    return Items(items=[FileModel.of(id, file) for file in store.runs.files(id)])


@serves(router, "/{id}/files/{name}", OF_A_RUN, "A file of a run")
async def download_file(
    id: RunId,
    name: Annotated[str, Path(description="Name from the list of files", examples=["result.json"])],
    request: Request,
    store: AppStore,
    artifacts: AppArtifacts,
) -> Response:
    stored = await run_in_threadpool(store.runs.file, id, name)
    path, filename = artifacts.path(stored), f"{id}-{stored.name}"
    return await send_file(request, Download(path, filename, stored.sha256, is_attachment=True, registered=stored))


@serves(
    router,
    "/{id}/log",
    (LOG,),
    "The output of the solver in the last attempt; of a running run, the output until now "
    "(`Range: bytes=1000-` returns the rest)",
)
async def download_log(id: RunId, request: Request, store: AppStore, artifacts: AppArtifacts) -> Response:
    file, registered = await run_in_threadpool(log_of, id, store, artifacts)
    if registered:
        return await send_file(request, Download(file, f"{id}-{LOG}", registered.sha256, registered=registered))
    if "range" in request.headers:
        return FileResponse(file, media_type=media_type_of(LOG))
    # It would send more bytes than announced while the log grows (up to 16 MiB).
    return Response(await run_in_threadpool(file.read_bytes), media_type=media_type_of(LOG))


def log_of(id: str, store: Store, artifacts: Artifacts) -> tuple[FilePath, Stored | None]:
    """The log of the last attempt of a run, and its record once that has ended; raises NotFound."""
    registered = next((stored for stored in store.runs.files(id) if stored.name == LOG), None)
    last = store.retention.last_attempts([id]).get(id)
    if last is None or last.token is None:
        raise NotFound("log", id)
    if registered and last.state not in (State.RUNNING, State.CANCELLING):
        return artifacts.path(registered), registered
    file = artifacts.log_of(id, last.attempt, last.token)
    if not file.is_file():
        raise NotFound("log", id)
    return file, None
