"""The queue as a whole: show, pause, resume."""

from fastapi import APIRouter

from service.api.access import Administrator
from service.api.routes.dependencies import AppStore
from service.api.schemas import QueueModel

router = APIRouter(prefix="/v1/queue", tags=["queue"])


@router.get("")
def show_queue(store: AppStore) -> QueueModel:
    """Whether the queue is paused or blocked, how many jobs it holds, and which process leads."""
    return QueueModel.of(store.queue())


@router.post("/pause")
def pause_queue(caller: Administrator, store: AppStore) -> QueueModel:
    """Stop starting runs. Running runs continue, finished sweeps are published, new sweeps are accepted."""
    return QueueModel.of(store.pause())


@router.post("/resume")
def resume_queue(caller: Administrator, store: AppStore) -> QueueModel:
    """Start runs again."""
    return QueueModel.of(store.resume())
