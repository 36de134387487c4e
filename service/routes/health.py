"""Is it alive, is it ready, what is it."""

import platform

from fastapi import APIRouter, Request

from service.errors import ServiceNotReady
from service.routes.given import StoreGiven
from service.schemas import Health, VersionModel
from service.version import version
from studies.run import PHYSICS_VERSION

router = APIRouter(tags=["service"])


@router.get("/livez")
async def show_life() -> Health:
    """The process answers."""
    return Health(status="alive")


@router.get("/readyz")
def show_readiness(request: Request, store: StoreGiven) -> Health:
    """The store can be written to, and somebody computes what is in the queue."""
    store.ping()
    if not request.app.state.engine.is_alive():
        raise ServiceNotReady("nobody computes what is in the queue")
    return Health(status="ready")


@router.get("/version")
def show_version() -> VersionModel:
    """What is running here."""
    return VersionModel(
        version=version(), physics_version=PHYSICS_VERSION, python=platform.python_version()
    )
