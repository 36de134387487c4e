"""What a monitor asks (Prometheus): the queue as the store has it, and the requests that were answered.

The registry is the app's own, and nothing that a user wrote is ever a label. What is about the queue is
read when it is asked for, so that every replica of the service says the same; counts of requests are
those of this process.
"""

import time
from collections.abc import Iterable, Iterator, Sequence

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

from service.api.event_streams import Live
from service.queue.status import DispatcherStatus
from service.records.jobs import (
    RUN_STATES,
    Cause,
    JobTally,
    Kind,
    QueueRow,
    State,
    StoreUnavailable,
)
from service.records.version import version
from service.store import Store
from studies.runs.run import PHYSICS_VERSION

CONTENT_TYPE = "text/plain; version=0.0.4; charset=utf-8"
# Seconds of a run: a second to a week, three a decade.
RUN_SECONDS = (1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1e3, 3e3, 1e4, 3e4, 1e5, 3e5)
REQUEST_SECONDS = (0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1.0, 2.5, 5.0, 10.0, 60.0)


class Metrics:
    """Everything that is measured, in one registry."""

    def __init__(self, store: Store, engine: DispatcherStatus, streams: Live):
        disable_created_metrics()  # a second series for each, of the moment that it began
        self._registry = CollectorRegistry()
        self._requests = Counter(
            "whipple_http_requests",
            "Requests answered, by template of the route.",
            ["route", "method", "status"],
            registry=self._registry,
        )
        self._seconds = Histogram(
            "whipple_http_request_seconds",
            "Seconds from a request to the end of its answer.",
            ["route", "method"],
            buckets=REQUEST_SECONDS,
            registry=self._registry,
        )
        ProcessCollector(registry=self._registry)
        self._registry.register(_OfService(engine, streams))
        self._registry.register(_OfStore(store))

    def note_request(self, *, route: str, method: str, status: int, seconds: float) -> None:
        """Count a request that was answered."""
        self._requests.labels(route, method, str(status)).inc()
        self._seconds.labels(route, method).observe(seconds)

    def text(self) -> bytes:
        """Everything, as a monitor reads it."""
        return generate_latest(self._registry)


class _Quiet(Collector):
    """A collector that is asked nothing when it is registered."""

    def describe(self) -> Iterable[Metric]:
        return ()


class _OfService(_Quiet):
    """What this process knows."""

    def __init__(self, engine: DispatcherStatus, streams: Live):
        self._engine, self._streams = engine, streams

    def collect(self) -> Iterator[Metric]:
        about = {"version": version(), "physics": str(PHYSICS_VERSION)}
        yield InfoMetricFamily("whipple", "What is running.", about)
        leads = float(self._engine.leads())
        yield GaugeMetricFamily("whipple_leader", "1 if this process gives the work out.", leads)
        slots = float(self._engine.workers() or 0)
        yield GaugeMetricFamily(
            "whipple_slots", "Runs that this process can compute at once.", slots
        )
        streams = float(self._streams.open)
        yield GaugeMetricFamily("whipple_event_streams", "Event streams that are open.", streams)


class _OfStore(_Quiet):
    """What every replica knows: jobs by state, attempts, seconds of runs."""

    def __init__(self, store: Store):
        self._store = store

    def collect(self) -> Iterator[Metric]:
        try:
            queue = self._store.queue()
            tallies = self._store.tally(RUN_SECONDS)
            attempts = self._store.attempts_by_cause()
        except StoreUnavailable:
            yield _store_up(0.0)
            return
        yield _store_up(1.0)
        yield from _jobs(tallies)
        yield from _queue(queue)
        yield _run_seconds(tallies)
        ended = CounterMetricFamily(
            "whipple_attempts_failed", "Attempts that did not succeed.", labels=["cause"]
        )
        for cause in Cause:
            ended.add_metric([cause.value], attempts.get(cause, 0))
        yield ended


def _store_up(value: float) -> Metric:
    return GaugeMetricFamily("whipple_store_up", "1 if the store answers.", value)


def _jobs(tallies: Sequence[JobTally]) -> Iterator[Metric]:
    """Runs and publications by state, those that there are none of too."""
    kinds = {
        Kind.RUN: (RUN_STATES, "whipple_runs", "Runs by state."),
        Kind.PUBLISH: (tuple(State), "whipple_publications", "Publications of sweeps by state."),
    }
    for kind, (states, name, meaning) in kinds.items():
        family = GaugeMetricFamily(name, meaning, labels=["state"])
        for state in states:
            jobs = sum(one.jobs for one in tallies if (one.kind, one.state) == (kind, state))
            family.add_metric([state.value], jobs)
        yield family


def _queue(queue: QueueRow) -> Iterator[Metric]:
    age = 0.0 if queue.oldest_queued is None else time.time() - queue.oldest_queued.timestamp()
    meaning = "Seconds that the run which waits longest has waited."
    yield GaugeMetricFamily("whipple_queue_age_seconds", meaning, age)
    paused = float(queue.paused is not None)
    yield GaugeMetricFamily("whipple_queue_paused", "1 if no run is begun.", paused)


def _run_seconds(tallies: Sequence[JobTally]) -> Metric:
    """Seconds of the attempts that gave a result, as a histogram."""
    ended = [one for one in tallies if one.kind is Kind.RUN and one.state is State.SUCCEEDED]
    edges = (*map(str, RUN_SECONDS), "+Inf")
    counts = [
        sum(one.jobs for one in ended if one.bucket is not None and one.bucket <= place)
        for place in range(len(edges))
    ]
    return HistogramMetricFamily(
        "whipple_run_seconds",
        "Seconds of the attempts that gave a result.",
        buckets=list(zip(edges, counts, strict=True)),
        sum_value=sum(one.seconds for one in ended),
    )
