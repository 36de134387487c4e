"""Routes of the interface, one file for each kind of resource; endpoints parse, call one function, and return.

To add one: a module here that offers its ``Routes`` as ``ROUTES``; a feature offers its own by an entry point of the
group ``whipple.service.api.routes``. Errors are raised as exceptions that carry their meaning;
``service.api.errors`` has the table that maps them to statuses.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

from fastapi import APIRouter, FastAPI, Request, Response
from pydantic import JsonValue

from solver.registry import entries

ProblemPage = Callable[[Request, int, Mapping[str, JsonValue], Mapping[str, str]], Response]


@dataclass(frozen=True)
class Routes:
    """What a module of this folder, or a feature, adds to the interface."""

    name: str
    # Addresses are matched in this order, which is that of the documentation too; those of features come first.
    place: int = 0
    guarded: tuple[APIRouter, ...] = ()  # need the scope ``read``; what changes something asks for more itself
    open: tuple[APIRouter, ...] = ()  # for callers without a key
    files: Mapping[str, Path] = field(default_factory=dict)  # folders of files for everyone, by address
    problem_page: ProblemPage | None = None  # shows a problem document to a browser
    components: Callable[[], Mapping[str, JsonValue]] | None = None  # schemas that its routes refer to, by name
    # Called with the service while it is built: adds middleware around that of the spine, or parts of its ``state``.
    prepare: Callable[[FastAPI], object] | None = None


@cache
def all_routes() -> tuple[Routes, ...]:
    """The routes of this folder and of features, in their order."""
    return tuple(sorted(entries("service.api.routes", "ROUTES").values(), key=lambda routes: routes.place))
