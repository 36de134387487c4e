"""The queue as a whole: show, pause, resume."""

from fastapi import APIRouter, Request
from starlette.concurrency import run_in_threadpool

from service.api.access import Administrator
from service.api.dependencies import AppReadiness, AppStore
from service.api.routes import Routes
from service.api.schemas import QueueModel
from service.api.turns import in_waiting_thread

router = APIRouter(prefix="/v1/queue", tags=["operations"])
ROUTES = Routes("queue", 40, guarded=(router,))


@router.get("")
async def show_queue(request: Request, store: AppStore, readiness: AppReadiness) -> QueueModel:
    """Whether the queue is paused or blocked, how many jobs it holds, and which process leads.

    Counts may be half a second old while nothing happens; the reason is that of `/readyz`.
    """
    problem = await in_waiting_thread(request, readiness.problem)
    return QueueModel.of(await run_in_threadpool(store.queue.status), None if problem is None else str(problem))


@router.post("/pause")
def pause_queue(caller: Administrator, store: AppStore) -> QueueModel:
    """Stop starting runs. Running runs continue, finished sweeps are published, new sweeps are accepted."""
    return QueueModel.of(store.queue.pause())


@router.post("/resume")
def resume_queue(caller: Administrator, store: AppStore) -> QueueModel:
    """Start runs again."""
    return QueueModel.of(store.queue.resume())
