"""The only place where the parts of the service are joined."""

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, closing, contextmanager
from pathlib import Path
from typing import Any, Protocol

from fastapi import FastAPI
from fastapi.staticfiles import StaticFiles

from service import errors
from service.access import Access, check_binding
from service.routes import catalogue, files, health, pages, runs, sweeps
from service.schemas import problem_schemas
from service.settings import Settings
from service.store import Store
from service.version import version

ROUTERS = (sweeps.router, files.router, runs.router, catalogue.router, health.router, pages.router)
STATIC = Path(__file__).parent / "static"
PROBLEM: dict[str, Any] = {
    "description": "a problem document (RFC 9457)",
    "content": {errors.MEDIA_TYPE: {"schema": {"$ref": "#/components/schemas/ProblemDocument"}}},
}


class Engine(Protocol):
    """What computes the queue while the service runs."""

    def is_alive(self) -> bool:
        """Whether somebody looks after the queue."""
        ...


StartEngine = Callable[[Settings, Store], AbstractContextManager[Engine]]


@contextmanager
def open_service(settings: Settings, start_engine: StartEngine) -> Iterator[FastAPI]:
    """The whole service while it is wanted: store, engine, and the interface to them."""
    check_binding(settings)
    settings.data.mkdir(parents=True, exist_ok=True)
    with closing(Store.open(settings.url)) as store, start_engine(settings, store) as engine:
        yield build_app(settings, store, engine)


def build_app(settings: Settings, store: Store, engine: Engine) -> FastAPI:
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
    app.state.settings, app.state.store, app.state.engine = settings, store, engine
    for router in ROUTERS:
        app.include_router(router)
    app.mount("/static", StaticFiles(directory=STATIC), name="static")
    app.add_middleware(Access, settings=settings)
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
