"""Runs: one simulation each."""

from fastapi import APIRouter

from service.routes.given import StoreGiven
from service.schemas import RunModel, RunQuestion

router = APIRouter(prefix="/v1/runs", tags=["runs"])


@router.get("/{id}")
def show_run(id: str, store: StoreGiven) -> RunQuestion:
    """A run: its question, complete, and how it went."""
    answer = RunModel.of(store.run(id))
    return RunQuestion(**dict(answer), question=dict(store.run_spec(id)))
