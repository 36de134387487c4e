"""Liveness, readiness, version and metrics of the service."""

import platform

from fastapi import APIRouter, Request, Response

from service import version
from service.api.dependencies import AppReadiness
from service.api.metrics import CONTENT_TYPE, Metrics
from service.api.routes import Routes
from service.api.schemas import Health, Readiness, VersionModel
from service.api.turns import in_waiting_thread
from studies.runs.run import PHYSICS_VERSION

router = APIRouter(tags=["operations"])
metrics_router = APIRouter(tags=["operations"])
ROUTES = Routes("health", 0, open=(router,), guarded=(metrics_router,))


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


@metrics_router.get(
    "/metrics", response_class=Response, responses={200: {"content": {"text/plain": {"schema": {"type": "string"}}}}}
)
async def show_metrics(request: Request) -> Response:
    """Metrics for Prometheus: runs by state, queue, attempts, requests."""
    metrics: Metrics = request.app.state.metrics
    return Response(await in_waiting_thread(request, metrics.text), media_type=CONTENT_TYPE)
