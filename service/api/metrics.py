"""Metrics for a monitor (Prometheus): the queue as the store has it, and the requests of this process.

The registry belongs to the app, and no label contains what a user wrote: owners are names of keys. Metrics of the queue
are read from the store on request, so every replica of the service reports the same.
"""

import time
from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING

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

from service import version
from service.api.event_streams import EventStreams
from service.api.readiness import ReadinessCheck
from service.records.jobs import RUN_SECONDS, RUN_STATES, Cause, Kind, QueueRow, RunTally, State, StoreUnavailable
from service.store import Store
from studies.runs.run import PHYSICS_VERSION

if TYPE_CHECKING:
    from service.queue.dispatcher import Dispatcher

CONTENT_TYPE = "text/plain; version=0.0.4; charset=utf-8"
REQUEST_SECONDS = (0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1.0, 2.5, 5.0, 10.0, 60.0)


class Metrics:
    """All metrics of a service, in one registry."""

    def __init__(self, store: Store, engine: "Dispatcher", streams: EventStreams, readiness: ReadinessCheck):
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
        self._registry.register(_ProcessMetrics(engine, streams))
        self._registry.register(_ServiceMetrics(store, engine, readiness))

    def record_request(self, *, route: str, method: str, status: int, seconds: float) -> None:
        """Count a request."""
        self._requests.labels(route, method, str(status)).inc()
        self._seconds.labels(route, method).observe(seconds)

    def text(self) -> bytes:
        """All metrics in the text format of Prometheus; waits for the database as long as the readiness check does."""
        return generate_latest(self._registry)


class _LazyCollector(Collector):
    """A collector that reads nothing at registration."""

    def describe(self) -> Iterable[Metric]:
        return ()


class _ProcessMetrics(_LazyCollector):
    """Metrics of this process."""

    def __init__(self, engine: "Dispatcher", streams: EventStreams):
        self._engine, self._streams = engine, streams

    def collect(self) -> Iterator[Metric]:
        versions = {"version": version(), "physics": str(PHYSICS_VERSION)}
        yield InfoMetricFamily("whipple", "Versions of this process.", versions)
        gauges = {
            "whipple_leader": ("1 if this process assigns the work, and the database lets it.", self._engine.leads()),
            "whipple_slots": ("Runs that this process can compute at once.", self._engine.workers()),
            "whipple_event_streams": ("Open event streams.", self._streams.open),
        }
        for name, (meaning, value) in gauges.items():
            yield GaugeMetricFamily(name, meaning, float(value or 0))


class _ServiceMetrics(_LazyCollector):
    """Metrics of what the service can do, and of the queue: jobs by state, failed attempts, seconds of runs."""

    def __init__(self, store: Store, engine: "Dispatcher", readiness: ReadinessCheck):
        self._store, self._engine, self._readiness = store, engine, readiness

    def collect(self) -> Iterator[Metric]:
        problem = self._readiness.problem()
        yield GaugeMetricFamily("whipple_ready", "1 if /readyz says that it is ready.", float(problem is None))
        is_refused = self._engine.is_refused() or isinstance(problem, StoreUnavailable)
        try:
            queue = self._store.queue.status()
            results = self._store.queue.tally()
            attempts, owned = self._store.queue.attempts_by_cause(), self._store.queue.tally_of_owners()
        except StoreUnavailable:
            yield _store_up(0.0)
            yield _blocked(1.0)
            return
        yield _store_up(float(not is_refused))
        yield _blocked(float(is_refused or bool(self._engine.blocked_reason() or queue.blocked_reason)))
        yield _jobs(Kind.RUN, RUN_STATES, queue, "whipple_runs", "Runs by state.")
        yield _jobs(Kind.PUBLISH, tuple(State), queue, "whipple_publications", "Publications of sweeps by state.")
        owners = GaugeMetricFamily("whipple_owner_runs", "Unfinished runs by owner.", labels=["owner", "state"])
        for owner, state, runs in owned:
            owners.add_metric([owner, state.value], runs)
        yield owners
        # A clock that was set back is before the moment at which the run was queued.
        age = 0.0 if queue.oldest_queued is None else max(0.0, time.time() - queue.oldest_queued.timestamp())
        meaning = "Seconds since the longest waiting run was queued."
        yield GaugeMetricFamily("whipple_queue_age_seconds", meaning, age)
        paused = float(queue.paused is not None)
        yield GaugeMetricFamily("whipple_queue_paused", "1 if the queue is paused.", paused)
        kept = float(queue.deletion_paused is not None)
        meaning = "1 if nothing is deleted by age: the clock has jumped."
        yield GaugeMetricFamily("whipple_deletion_paused", meaning, kept)
        yield _run_seconds(results)
        failed = CounterMetricFamily("whipple_attempts_failed", "Attempts that did not succeed.", labels=["cause"])
        for cause in Cause:
            failed.add_metric([cause.value], attempts.get(cause, 0))
        yield failed


def _store_up(value: float) -> Metric:
    return GaugeMetricFamily("whipple_store_up", "1 if the database responds and takes what is written.", value)


def _blocked(value: float) -> Metric:
    return GaugeMetricFamily("whipple_queue_blocked", "1 if nothing begins: database, disk, bucket, no worker.", value)


def _jobs(kind: Kind, states: Sequence[State], queue: QueueRow, name: str, meaning: str) -> Metric:
    """Jobs of a kind in each state, zeros included."""
    family = GaugeMetricFamily(name, meaning, labels=["state"])
    for state in states:
        family.add_metric([state.value], queue.jobs.get((kind, state), 0))
    return family


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
