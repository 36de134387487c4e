"""The entries of a folder: each module of a kind's package offers one, or a tuple of several; no list is edited.

A module named ``maiden.py`` in ``studies/laws`` offers its law under the attribute ``LAW``;
``entries("studies.laws", "LAW")`` finds it. A feature, or another distribution, adds entries through the entry-point
group ``whipple.studies.laws``, whose values name an entry, a tuple of entries or a folder whose modules offer theirs as
ours do (``shields = "studies.shields.laws"``); our own groups are read from the tree's ``pyproject.toml`` where it
lies beside the code, since the metadata of an installation are those of its day. A module that cannot be imported, or
lacks its entry, stops the start and is named.
"""

import importlib
import pkgutil
import tomllib
from collections.abc import Mapping
from functools import cache
from importlib.metadata import EntryPoint, EntryPoints, entry_points
from pathlib import Path
from types import MappingProxyType, ModuleType
from typing import Any

from solver.errors import RegistryError

OURS = "whipple."  # how the names of our groups begin
TREE = Path(__file__).parents[1] / "pyproject.toml"


@cache
def entries(package: str, kind: str) -> Mapping[str, Any]:
    """Entries of one kind by their ``name``, sorted.

    A package, or a module in its place, may offer some itself. A module whose name begins with an underscore offers
    none; a folder inside may offer none.
    """
    members: dict[str, Any] = {}
    own = importlib.import_module(package)
    _add(members, getattr(own, kind, ()), package)
    if hasattr(own, "__path__"):
        _add_folder(members, own, kind)
    for point in points(package):
        offered = _loaded(point)
        if isinstance(offered, ModuleType):
            _add_folder(members, offered, kind)
        else:
            _add(members, offered, point.value)
    return MappingProxyType(dict(sorted(members.items())))


def folders(package: str) -> list[ModuleType]:
    """A package, and the folders that entry points add to it."""
    added = (_loaded(point) for point in points(package))
    return [importlib.import_module(package), *(folder for folder in added if isinstance(folder, ModuleType))]


def points(package: str) -> EntryPoints:
    """Entry points by which features and other distributions add to a package."""
    group: EntryPoints = _all_points().select(group=f"{OURS}{package}")
    return group


@cache
def _all_points() -> EntryPoints:
    known = entry_points()
    installed = [point for group in known.groups if group.startswith(OURS) for point in known.select(group=group)]
    if not TREE.exists():
        return EntryPoints(installed)
    project = tomllib.loads(TREE.read_text(encoding="utf-8"))["project"]
    own = (
        EntryPoint(name, value, group)
        for group, points in project.get("entry-points", {}).items()
        for name, value in points.items()
    )
    others = (point for point in installed if point.dist is None or point.dist.name != project["name"])
    return EntryPoints((*own, *others))


def _loaded(point: EntryPoint) -> Any:
    try:
        return point.load()
    except Exception as error:
        raise RegistryError(f"entry point {point.name!r} of {point.group}: {error}") from error


def _load(module_name: str, kind: str, default: tuple[()] | None) -> Any:
    try:
        module = importlib.import_module(module_name)
    except Exception as error:
        raise RegistryError(f"{module_name} cannot be imported: {error}") from error
    offered = getattr(module, kind, default)
    if offered is None:
        raise RegistryError(f"{module_name} has no {kind}: each module of this folder offers one")
    return offered


def _add_folder(members: dict[str, Any], folder: ModuleType, kind: str) -> None:
    modules = {module.name: module.ispkg for module in pkgutil.iter_modules(folder.__path__)}
    for name, is_folder in sorted(modules.items()):
        if not name.startswith("_"):
            module_name = f"{folder.__name__}.{name}"
            _add(members, _load(module_name, kind, () if is_folder else None), module_name)


def _add(members: dict[str, Any], offered: Any, origin: str) -> None:
    # Entries may be named tuples themselves.
    for entry in offered if type(offered) is tuple else (offered,):
        if entry.name in members:
            raise RegistryError(f"{origin} offers {entry.name!r} a second time")
        members[entry.name] = entry
