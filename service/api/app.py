"""The only place where the parts of the service are joined."""

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, closing, contextmanager
from pathlib import Path
from typing import Any

from fastapi import FastAPI
from fastapi.staticfiles import StaticFiles

from service.api import errors
from service.api.access import Access, check_binding
from service.api.event_streams import Live
from service.api.keys import allows
from service.api.metrics import Metrics
from service.api.partial_cubes import PartialCubes
from service.api.request_log import RequestLog
from service.api.routes import (
    catalogue,
    events,
    files,
    health,
    pages,
    queue,
    runs,
    sweeps,
)
from service.api.schemas import problem_schemas
from service.queue import data_identity as identity
from service.queue.status import DispatcherStatus
from service.records.jobs import Scope
from service.records.settings import Settings
from service.records.version import version
from service.store import Store

__all__ = ["DispatcherStatus", "StartEngine", "build_app", "open_service"]

# Whoever reads needs a key where keys are needed; what changes something asks for more, route by route.
GUARDED = (
    *(sweeps.router, files.router, runs.router, queue.router, events.router),
    *(catalogue.router, health.metrics_router, pages.router),
)
# Alive, ready, version: asked by machines that have no key; and what the interface is.
OPEN = (health.router, pages.docs_router)
STATIC = Path(__file__).parent / "static"
CACHE = "cache"  # folder of partial cubes, in the data directory
PROBLEM: dict[str, Any] = {
    "description": "a problem document (RFC 9457)",
    "content": {errors.MEDIA_TYPE: {"schema": {"$ref": "#/components/schemas/ProblemDocument"}}},
}

StartEngine = Callable[[Settings, Store], AbstractContextManager[DispatcherStatus]]


@contextmanager
def open_service(settings: Settings, start_engine: StartEngine) -> Iterator[FastAPI]:
    """The whole service while it is wanted: store, engine, and the interface to them."""
    if not settings.has_replicas:  # the database is a file there
        settings.data.mkdir(parents=True, exist_ok=True)
    with closing(Store.open(settings.url)) as store:
        identity.settle(settings, store)
        check_binding(settings, has_keys=store.has_keys())
        with start_engine(settings, store) as engine:
            app = build_app(settings, store, engine)
            with closing(app.state.live):
                yield app


def build_app(settings: Settings, store: Store, engine: DispatcherStatus) -> FastAPI:
    """The interface to a store and to what computes its queue."""
    app = FastAPI(
        title="whipple",
        summary="Hypervelocity impact: sweeps in, cubes and law reports out.",
        version=version(),
        docs_url=None,  # theirs asks a content network for its script
        redoc_url=None,
        responses={"4XX": PROBLEM, "5XX": PROBLEM},
        generate_unique_id_function=lambda route: route.name,
    )
    live = Live(store)
    metrics = Metrics(store, engine, live)
    app.state.settings, app.state.store, app.state.engine = settings, store, engine
    app.state.live, app.state.metrics = live, metrics
    app.state.lookout = health.Lookout()
    app.state.partial_cubes = PartialCubes(settings.data / CACHE)
    for router in OPEN:
        app.include_router(router)
    for router in GUARDED:
        app.include_router(router, dependencies=[allows(Scope.READ)])
    app.mount("/static", StaticFiles(directory=STATIC), name="static")
    app.add_middleware(Access, settings=settings)
    app.add_middleware(RequestLog, metrics=metrics)  # the last one is the outermost
    errors.install(app)
    _describe_problems(app)
    return app


def _describe_problems(app: FastAPI) -> None:
    """Add to the OpenAPI document what every error looks like."""
    plain = app.openapi

    def openapi() -> dict[str, Any]:
        document = plain()
        document["components"]["schemas"] |= problem_schemas()
        return document

    app.openapi = openapi  # type: ignore[method-assign]
