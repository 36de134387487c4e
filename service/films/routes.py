"""Films, final states and views of runs, made when they are asked for."""

from typing import Annotated, Literal

from fastapi import APIRouter, Query, Request, Response
from starlette.concurrency import run_in_threadpool

from service.api.dependencies import AppStore, RunId, in_child
from service.api.downloads import bring_back, serves
from service.api.routes import Routes
from service.conversions.routes import send_made
from service.files.artifacts import Artifacts
from service.films.files import packed_view
from service.records.jobs import VIEWS, NotFound
from studies.quantities.files import FILM, RESULT, STATE, VTK

router = APIRouter(prefix="/v1/runs", tags=["runs"])
ROUTES = Routes("films", 31, guarded=(router,))

QUICK = 32 << 20  # bytes of a file of which a view takes little
FilmField = Literal["speed", "pressure", "temperature", "plastic_strain", "damage"]  # studies.films.film.SCALARS


@serves(
    router,
    f"/{{id}}/{VTK}",
    (VTK,),
    "Film and final state for ParaView and other readers of VTK (`film.pvd`, `state.vtu`), with units and times; what "
    "is in it follows from the retention of the run",
)
async def download_vtk(id: RunId, request: Request, store: AppStore) -> Response:
    files = {file.name: file for file in await run_in_threadpool(store.runs.files, id)}
    if not {STATE, FILM} & set(files):
        raise NotFound("file", f"{id}/{STATE}")
    sources = [files[name] for name in (STATE, FILM, RESULT) if name in files]
    return await send_made(request, VTK, sources, f"{id}-{VTK}", is_attachment=True)


@serves(
    router,
    "/{id}/film.gif",
    ("film.gif",),
    "The film of a run that kept it, as an animation: one section, coloured by a field",
)
async def download_animation(
    id: RunId,
    request: Request,
    store: AppStore,
    field: Annotated[FilmField, Query(description="What the colours show")] = "speed",
) -> Response:
    film = await run_in_threadpool(store.runs.file, id, FILM)
    return await send_made(request, "gif", [film], f"{id}-film.gif", field=field)


@router.get("/{id}/views/{view}", include_in_schema=False)
async def download_view(id: RunId, request: Request, store: AppStore, view: str) -> Response:
    """What the page of a run draws, packed (``studies.films.packed``)."""
    files = {file.name: file for file in await run_in_threadpool(store.runs.files, id)}
    source = next((files[name] for name in VIEWS.get(view, ()) if name in files), None)
    if source is None:
        raise NotFound("view", f"{id}/{view[:80]}")
    run = await run_in_threadpool(store.runs.spec, id)
    headers = {"Content-Encoding": "gzip"}
    if source.size <= QUICK:  # by a child that is there already, which takes a tenth of a second in place of three
        artifacts: Artifacts = request.app.state.artifacts
        await bring_back(request, source)
        if await run_in_threadpool(artifacts.may_be_shown, source):
            content = await in_child(request, packed_view, view, artifacts.path(source), run)
            return Response(content, media_type="application/octet-stream", headers=headers)
    return await send_made(request, f"{view}.view", [source], f"{id}-{view}", headers=headers, run=run)
