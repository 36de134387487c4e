"""Metrics for a monitor (Prometheus): the queue as the store has it, and the requests of this process.

The registry belongs to the app, and no label contains what a user wrote: owners are names of keys. Metrics of the queue
are read from the store on request, so every replica of the service reports the same.
"""

import time
from collections import Counter as Counts
from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING

from fastapi import APIRouter, FastAPI, Request, Response
from prometheus_client import (
    CollectorRegistry,
    Counter,
    Histogram,
    ProcessCollector,
    disable_created_metrics,
    generate_latest,
)
from prometheus_client.metrics_core import (
    CounterMetricFamily,
    GaugeMetricFamily,
    HistogramMetricFamily,
    InfoMetricFamily,
    Metric,
)
from prometheus_client.registry import Collector
from starlette.types import Scope

from service import version
from service.api.middleware import method_of, route_of
from service.api.readiness import ReadinessCheck
from service.api.routes import Routes
from service.api.turns import in_waiting_thread
from service.records.jobs import RUN_SECONDS, RUN_STATES, UNSUCCESSFUL, Cause, Kind, RunTally, StoreUnavailable
from service.store import Store
from studies.runs.run import PHYSICS_VERSION

if TYPE_CHECKING:
    from service.queue.dispatcher import Dispatcher

CONTENT_TYPE = "text/plain; version=0.0.4; charset=utf-8"
REQUEST_SECONDS = (0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1.0, 2.5, 5.0, 10.0, 60.0)


class Metrics:
    """All metrics of a service, in one registry."""

    def __init__(self, service: FastAPI):
        # It would add a second series to each counter, with its time of creation.
        disable_created_metrics()
        self._registry = CollectorRegistry()
        self._requests = Counter(
            "whipple_http_requests",
            "Requests, by template of the route.",
            ["route", "method", "status"],
            registry=self._registry,
        )
        self._seconds = Histogram(
            "whipple_http_request_seconds",
            "Seconds from a request to the end of its response.",
            ["route", "method"],
            buckets=REQUEST_SECONDS,
            registry=self._registry,
        )
        ProcessCollector(registry=self._registry)
        state = service.state
        self._registry.register(_ServiceMetrics(state.store, state.engine, state.open_streams, state.readiness))
        state.metrics = self
        state.at_response.append(self._count)

    def _count(self, scope: Scope, status: int, seconds: float) -> None:
        """Count a request that was responded to."""
        route, method = route_of(scope), method_of(scope)
        self._requests.labels(route, method, str(status)).inc()
        self._seconds.labels(route, method).observe(seconds)

    def text(self) -> bytes:
        """All metrics in the text format of Prometheus; waits for the database as long as the readiness check does."""
        return generate_latest(self._registry)


class _ServiceMetrics(Collector):
    """Metrics of this process, and of the queue: jobs by state, failed attempts, seconds of runs."""

    def __init__(self, store: Store, engine: "Dispatcher", streams: Counts[str], readiness: ReadinessCheck):
        self._store, self._engine, self._streams, self._readiness = store, engine, streams, readiness

    def describe(self) -> Iterable[Metric]:
        """Nothing, so that nothing is read at registration."""
        return ()

    def collect(self) -> Iterator[Metric]:
        versions = {"version": version(), "physics": str(PHYSICS_VERSION)}
        yield InfoMetricFamily("whipple", "Versions of this process.", versions)
        leads = bool(self._engine.leads())
        yield _gauge("leader", "1 if this process assigns the work, and the database lets it.", leads)
        yield _gauge("slots", "Runs that this process can compute at once.", self._engine.workers() or 0)
        yield _gauge("event_streams", "Open event streams.", self._streams.total())
        problem = self._readiness.problem()
        yield _gauge("ready", "1 if /readyz says that it is ready.", problem is None)
        is_refused = self._engine.is_refused() or isinstance(problem, StoreUnavailable)
        try:
            queue, results = self._store.queue.status(), self._store.queue.tally()
            attempts, owned = self._store.queue.attempts_by_cause(), self._store.queue.tally_of_owners()
        except StoreUnavailable:
            yield from _state_of_store(is_up=False, is_blocked=True)
            return
        is_blocked = is_refused or bool(self._engine.blocked_reason() or queue.blocked_reason)
        yield from _state_of_store(is_up=not is_refused, is_blocked=is_blocked)
        runs = [(state, queue.jobs.get((Kind.RUN, state), 0)) for state in RUN_STATES if state in UNSUCCESSFUL]
        yield _gauges("runs", "Runs by state, but for those that succeeded.", ["state"], runs)
        publications = [(state, queue.jobs.get((Kind.PUBLISH, state), 0)) for state in UNSUCCESSFUL]
        yield _gauges("publications", "Publications by state, but for those that succeeded.", ["state"], publications)
        yield _gauges("owner_runs", "Unfinished runs by owner.", ["owner", "state"], owned)
        # A clock that was set back is before the moment at which the run was queued.
        age = 0.0 if queue.oldest_queued is None else max(0.0, time.time() - queue.oldest_queued.timestamp())
        yield _gauge("queue_age_seconds", "Seconds since the longest waiting run was queued.", age)
        yield _gauge("queue_paused", "1 if the queue is paused.", queue.paused is not None)
        is_kept = queue.deletion_paused is not None
        yield _gauge("deletion_paused", "1 if nothing is deleted by age: the clock has jumped.", is_kept)
        yield _run_seconds(results)
        failed = CounterMetricFamily("whipple_attempts_failed", "Attempts that did not succeed.", labels=["cause"])
        for cause in Cause:
            failed.add_metric([cause.value], attempts.get(cause, 0))
        yield failed


def _gauge(name: str, meaning: str, value: float) -> Metric:
    return GaugeMetricFamily(f"whipple_{name}", meaning, float(value))


def _gauges(name: str, meaning: str, labels: Sequence[str], rows: Iterable[tuple[*tuple[str, ...], float]]) -> Metric:
    """A gauge with a value for each row of labels."""
    family = GaugeMetricFamily(f"whipple_{name}", meaning, labels=labels)
    for *texts, value in rows:
        family.add_metric([*map(str, texts)], value)
    return family


def _state_of_store(*, is_up: bool, is_blocked: bool) -> Iterator[Metric]:
    yield _gauge("store_up", "1 if the database responds and takes what is written.", is_up)
    yield _gauge("queue_blocked", "1 if nothing begins: database, disk, bucket, no worker.", is_blocked)


def _run_seconds(results: Sequence[RunTally]) -> Metric:
    """Histogram of the seconds of successful attempts."""
    edges = (*map(str, RUN_SECONDS), "+Inf")
    counts = [sum(tally.attempts for tally in results if tally.bucket <= index) for index in range(len(edges))]
    return HistogramMetricFamily(
        "whipple_run_seconds",
        "Seconds of successful attempts.",
        buckets=list(zip(edges, counts, strict=True)),
        sum_value=sum(tally.seconds for tally in results),
    )


router = APIRouter(tags=["operations"])
ROUTES = Routes("monitoring", 1, guarded=(router,), prepare=Metrics)


@router.get(
    "/metrics", response_class=Response, responses={200: {"content": {"text/plain": {"schema": {"type": "string"}}}}}
)
async def show_metrics(request: Request) -> Response:
    """Metrics for Prometheus: runs by state, queue, attempts, requests."""
    metrics: Metrics = request.app.state.metrics
    return Response(await in_waiting_thread(request, metrics.text), media_type=CONTENT_TYPE)
