"""The cost of a sweep, over HTTP."""

from fastapi import APIRouter, Request
from pydantic import Field
from starlette.concurrency import run_in_threadpool

from service.api.dependencies import PostedDocument, in_child
from service.api.routes import Routes
from service.api.routes.sweeps import SWEEP_BODY
from service.api.schemas import Answer
from service.estimates.estimate import EstimatedSweep, estimated
from service.store import Store
from studies.sweeps.cost import OF_SWEEP, PresetCost

router = APIRouter(prefix="/v1/sweeps", tags=["submit"])
ROUTES = Routes("estimates", 11, guarded=(router,))


class PresetModel(Answer):
    """The sweep with `accuracy: name` in place of `resolution`, and its cost."""

    name: str
    error: float = Field(description="Mesh error of each point, relative: half-width of 95 %")
    cells: tuple[float, float] | None = Field(description="Fewest and most cells across the diameter; null: `reason`")
    runs: int = Field(description="Points of the sweep, each on one grid")
    core_seconds: float | None = Field(description="Estimated core seconds of all runs; null: see `reason`")
    bytes: int | None = Field(description="Size of all results")
    reason: str = Field(description="Why this sweep cannot have the accuracy; empty if it can")

    @classmethod
    def of(cls, preset: PresetCost, rate: float) -> "PresetModel":
        """A preset; ``rate`` is measured over estimated seconds."""
        fields = {name: value for name, value in vars(preset).items() if name != "cost"}
        cost = preset.cost
        return cls(
            **fields,
            core_seconds=None if cost is None else cost.core_seconds * rate,
            bytes=None if cost is None else cost.bytes,
        )


class EstimateModel(Answer):
    """The cost of a sweep; nothing was stored."""

    runs: int = Field(description="Points of the sweep, each at every resolution and offset")
    looked_at: int = Field(description="Points whose runs were looked at; they were drawn evenly, and stand for all")
    reused: int = Field(description="Distinct runs that are computed or under way already")
    core_seconds: float = Field(
        description="Estimated core seconds of the runs that remain, of the cube and of the report"
    )
    seconds: float = Field(description="The same with the runs divided among the workers of this service")
    bytes: int = Field(description="Size of the results")
    memory: int = Field(description="Memory of the largest run's process, bytes")
    is_measured: bool = Field(description="Whether the times are measured here for this scenario")
    warnings: list[str] = Field(description="Doubts about points and constants that are allowed and hardly useful")
    presets: list[PresetModel] = Field(description="Cost of the sweep at each `accuracy`")


@router.post("/estimate", openapi_extra=SWEEP_BODY)
async def estimate_sweep(request: Request, posted: PostedDocument) -> EstimateModel:
    """Estimate the cost of a sweep, as it is and at each `accuracy`; of a search, its most runs. Nothing is stored.

    Times are those that this service measured for runs of the same scenario, if there are any. Of many points, some
    are drawn evenly and stand for all; the submission checks each.
    """
    return await run_in_threadpool(priced, request, await in_child(request, estimated, posted))


def priced(request: Request, sweep: EstimatedSweep) -> EstimateModel:
    """The cost of a sweep with what this service has computed and measured."""
    store: Store = request.app.state.store
    runs = sweep.cost.priced
    existing = store.runs.known(run.id for run in runs)
    new = [run for run in runs if run.id not in existing]
    measured_rate = store.runs.measured_rate(sweep.scenario)
    rate = 1.0 if measured_rate is None else measured_rate
    cost = sweep.cost.of(new)
    workers = request.app.state.engine.workers() or request.app.state.settings.workers
    new_runs = round(sum(run.share for run in new))
    return EstimateModel(
        runs=sweep.cost.runs,
        looked_at=sweep.cost.looked_at,
        reused=round(sum(run.share for run in runs if run.id in existing)),
        core_seconds=cost.core_seconds * rate + OF_SWEEP.core_seconds,
        seconds=cost.core_seconds * rate / max(1, min(workers, new_runs)) + OF_SWEEP.core_seconds,
        bytes=cost.bytes + OF_SWEEP.bytes,
        memory=cost.memory,
        is_measured=measured_rate is not None,
        warnings=sweep.warnings,
        presets=[PresetModel.of(preset, rate) for preset in sweep.presets],
    )
