"""The queue as a whole: show, pause, resume."""

from fastapi import APIRouter

from service.api.access import Administrator
from service.api.routes.dependencies import AppReadiness, AppStore
from service.api.schemas import QueueModel

router = APIRouter(prefix="/v1/queue", tags=["operations"])


@router.get("")
def show_queue(store: AppStore, readiness: AppReadiness) -> QueueModel:
    """Whether the queue is paused or blocked, how many jobs it holds, and which process leads.

    Counts may be half a second old while nothing happens; the reason is that of `/readyz`.
    """
    problem = readiness.problem()
    return QueueModel.of(store.queue.status(), None if problem is None else str(problem))


@router.post("/pause")
def pause_queue(caller: Administrator, store: AppStore) -> QueueModel:
    """Stop starting runs. Running runs continue, finished sweeps are published, new sweeps are accepted."""
    return QueueModel.of(store.queue.pause())


@router.post("/resume")
def resume_queue(caller: Administrator, store: AppStore) -> QueueModel:
    """Start runs again."""
    return QueueModel.of(store.queue.resume())
