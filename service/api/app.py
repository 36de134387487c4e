"""The application: the only place where the parts of the service are joined."""

from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, closing, contextmanager
from typing import TYPE_CHECKING

from fastapi import FastAPI
from fastapi.staticfiles import StaticFiles

from service import version
from service.api import errors
from service.api.access import Access, KnownCallers, MinuteCounter, check_binding, requires
from service.api.middleware import Heads, RequestLog
from service.api.readers import Readers
from service.api.readiness import ReadinessCheck
from service.api.routes import all_routes
from service.api.turns import Turns, WaitingThreads
from service.files.artifacts import Artifacts
from service.queue import data_identity as identity
from service.records.jobs import Scope
from service.settings import Settings
from service.store import Store

if TYPE_CHECKING:
    from service.queue.dispatcher import Dispatcher

StartEngine = Callable[[Settings, Store], AbstractContextManager["Dispatcher"]]


@contextmanager
def open_service(settings: Settings, start_engine: StartEngine) -> Iterator[FastAPI]:
    """Store, engine and app for the duration of a block."""
    # A database on SQLite is a file in the data directory.
    if not settings.has_replicas:
        settings.data.mkdir(parents=True, exist_ok=True)
    with closing(Store.open(settings.url)) as store:
        identity.settle(settings, store)
        check_binding(settings, has_keys=store.keys.any_usable())
        with start_engine(settings, store) as engine:
            app = build_app(settings, store, engine)
            try:
                yield app
            finally:
                for end in app.state.at_end:
                    end()


def build_app(settings: Settings, store: Store, engine: "Dispatcher") -> FastAPI:
    """The HTTP interface to a store and to the engine that computes its queue."""
    app = FastAPI(
        title="whipple",
        summary="Compute sweeps of hypervelocity impacts, and compare the results with published laws.",
        version=version(),
        license_info={"name": "BSD 3-Clause License", "identifier": "BSD-3-Clause"},
        servers=[{"url": "/", "description": "The service that this document comes from"}],
        docs_url=None,  # FastAPI's own page loads a script from a content network
        redoc_url=None,
        openapi_url=None,  # FastAPI's own route writes the document anew for each request
        responses={"4XX": errors.PROBLEM, "5XX": errors.PROBLEM},
        generate_unique_id_function=lambda route: route.name,
    )
    readiness = ReadinessCheck(settings, store, engine)
    app.state.settings, app.state.store, app.state.engine = settings, store, engine
    app.state.artifacts, app.state.local_artifacts = Artifacts.of(settings), Artifacts(settings.data)
    app.state.open_streams = Counter[str]()  # connections that stay open, by the name of their key
    app.state.at_end = []  # functions that are called before connections are closed
    app.state.at_response = []  # functions that are called with the scope, status and seconds of each request
    app.state.problem_page = None  # makes the page of an error, where a feature with pages offers one
    app.state.requests, app.state.wrong_keys = MinuteCounter(), MinuteCounter()
    app.state.readers, app.state.known_callers = Readers(), KnownCallers()
    app.state.waiting_threads = WaitingThreads()
    app.state.readiness = readiness
    for routes in all_routes():
        for router in routes.open:
            app.include_router(router)
        for router in routes.guarded:
            app.include_router(router, dependencies=[requires(Scope.READ)])
        for address, folder in routes.files.items():
            app.mount(address, StaticFiles(directory=folder))
        app.state.problem_page = routes.problem_page or app.state.problem_page
    app.add_middleware(Access, settings=settings)
    app.add_middleware(Turns, callers=app.state.known_callers)
    app.add_middleware(Heads)
    for routes in all_routes():
        if routes.prepare is not None:
            routes.prepare(app)
    # The middleware added last is the outermost.
    app.add_middleware(RequestLog)
    errors.install(app)
    return app
