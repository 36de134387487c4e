"""The queue as a whole: look, pause, resume."""

from fastapi import APIRouter

from service.api.keys import Administrator
from service.api.queue_schemas import QueueModel
from service.api.routes.given import StoreGiven

router = APIRouter(prefix="/v1/queue", tags=["queue"])


@router.get("")
def show_queue(store: StoreGiven) -> QueueModel:
    """Whether it is paused, what is in it, and who works through it."""
    return QueueModel.of(store.queue())


@router.post("/pause")
def pause_queue(caller: Administrator, store: StoreGiven) -> QueueModel:
    """Begin no more runs. Those under way go on, finished sweeps are published, new ones are accepted."""
    return QueueModel.of(store.pause())


@router.post("/resume")
def resume_queue(caller: Administrator, store: StoreGiven) -> QueueModel:
    """Begin runs again."""
    return QueueModel.of(store.resume())
