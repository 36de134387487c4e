"""Runs: one simulation each, with its log and its files."""

from typing import Annotated

from fastapi import APIRouter, Path, Request, Response
from fastapi.responses import FileResponse

from service.api.downloads import Offer, send
from service.api.routes.given import ArtifactsGiven, RunId, StoreGiven
from service.api.routes.serving import served_as, serves
from service.api.schemas import FileList, RunModel, RunQuestion
from service.files.artifacts import LOG, OF_A_RUN
from service.records.jobs import NotFound, State

router = APIRouter(prefix="/v1/runs", tags=["runs"])

FileName = Annotated[str, Path(description="as the list of files has it")]


@router.get("/{id}")
def show_run(id: RunId, store: StoreGiven) -> RunQuestion:
    """A run: its question, complete, and how it went."""
    answer = RunModel.of(store.run(id))
    return RunQuestion(**dict(answer), question=dict(store.run_spec(id)))


@router.get("/{id}/files")
def list_files(id: RunId, store: StoreGiven) -> FileList:
    """The files that are kept of a run: as many as the sweeps that asked for it want."""
    return FileList.of(id, store.run_files(id))


@serves(router, "/{id}/files/{name}", OF_A_RUN, "a file of a run")
def download_file(
    id: RunId,
    name: FileName,
    request: Request,
    store: StoreGiven,
    artifacts: ArtifactsGiven,
) -> Response:
    stored = store.run_file(id, name)
    offer = Offer(
        path=artifacts.path(stored),
        media_type=served_as(stored.name),
        filename=f"{id}-{stored.name}",
        sha256=stored.sha256,
        attachment=True,
    )
    return send(request, offer)


@serves(
    router,
    "/{id}/log",
    (LOG,),
    "what the solver printed in the last attempt; of a running run, until now "
    "(`Range: bytes=1000-` is what came since)",
)
def download_log(
    id: RunId, request: Request, store: StoreGiven, artifacts: ArtifactsGiven
) -> Response:
    registered = [stored for stored in store.run_files(id) if stored.name == LOG]
    last = store.last_attempts([id]).get(id)
    if last is None or last.token is None:
        raise NotFound("log", id)
    filename, media_type = f"{id}-{LOG}", served_as(LOG)
    if registered and last.state not in (State.RUNNING, State.CANCELLING):
        [log] = registered
        return send(request, Offer(artifacts.path(log), media_type, filename, log.sha256))
    file = artifacts.log_of(id, last.attempt, last.token)
    if not file.is_file():
        raise NotFound("log", id)
    if "range" in request.headers:
        return FileResponse(file, media_type=media_type)
    # ``FileResponse`` would send more than it announced of a file that grows; a log has at most 16 MiB.
    return Response(file.read_bytes(), media_type=media_type)
