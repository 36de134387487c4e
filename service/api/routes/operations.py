"""Routes for operators: liveness, readiness, version, and the queue as a whole."""

import platform

from fastapi import APIRouter, Request
from starlette.concurrency import run_in_threadpool

from service import version
from service.api.access import Administrator
from service.api.dependencies import AppReadiness, AppStore
from service.api.routes import Routes
from service.api.schemas import Health, QueueModel, Readiness, VersionModel
from service.api.turns import in_waiting_thread
from studies.runs.run import PHYSICS_VERSION

router = APIRouter(tags=["operations"])
guarded_router = APIRouter(tags=["operations"])
ROUTES = Routes("operations", 0, open=(router,), guarded=(guarded_router,))


@router.get("/livez")
async def show_liveness() -> Health:
    """The process responds."""
    return Health(status="alive")


@router.get("/readyz")
async def show_readiness(readiness: AppReadiness) -> Readiness:
    """The database and the data directory are writable, and the queue has a leader with workers."""
    return await readiness.awaited()


@router.get("/version")
def show_version() -> VersionModel:
    """Versions of the service, its physics and Python."""
    return VersionModel(version=version(), physics_version=PHYSICS_VERSION, python=platform.python_version())


@guarded_router.get("/v1/queue")
async def show_queue(request: Request, store: AppStore, readiness: AppReadiness) -> QueueModel:
    """Whether the queue is paused or blocked, how many jobs it holds, and which process leads.

    The reason is that of `/readyz`.
    """
    problem = await in_waiting_thread(request, readiness.problem)
    return QueueModel.of(await run_in_threadpool(store.queue.status), None if problem is None else str(problem))


@guarded_router.post("/v1/queue/pause")
def pause_queue(caller: Administrator, store: AppStore) -> QueueModel:
    """Stop starting runs. Running runs continue, finished sweeps are published, new sweeps are accepted."""
    return QueueModel.of(store.queue.pause())


@guarded_router.post("/v1/queue/resume")
def resume_queue(caller: Administrator, store: AppStore) -> QueueModel:
    """Start runs again."""
    return QueueModel.of(store.queue.resume())
