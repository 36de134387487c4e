"""The address of the metrics."""

from fastapi import APIRouter, Request, Response

from service.api.routes import Routes
from service.api.turns import in_waiting_thread
from service.monitoring.metrics import CONTENT_TYPE, Metrics

router = APIRouter(tags=["operations"])
ROUTES = Routes(
    "monitoring", 1, guarded=(router,), prepare=lambda service: service.add_middleware(Metrics, service=service)
)


@router.get(
    "/metrics", response_class=Response, responses={200: {"content": {"text/plain": {"schema": {"type": "string"}}}}}
)
async def show_metrics(request: Request) -> Response:
    """Metrics for Prometheus: runs by state, queue, attempts, requests."""
    metrics: Metrics = request.app.state.metrics
    return Response(await in_waiting_thread(request, metrics.text), media_type=CONTENT_TYPE)
