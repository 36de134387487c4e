"""The rooms of a cube: the groups of its file, an xarray ``DataTree``.

The root has the axes and what a person reads first, of each point; ``laws``, ``observations``, ``refinement`` (every
grid and offset), ``quantities``, ``runs`` and ``inputs`` have the rest, on the axes of the root and on dimensions of
their own. A variable states its room where it is declared. Whipple itself works with all variables in one dataset.
"""

from collections.abc import Hashable, Sequence

import xarray as xr

from studies.cubes.points import points_of, refinements_of
from studies.cubes.variable import ROOMS, ROOT, Room

# Attributes of one room, for programs; all others stand at the root.
ATTRIBUTES: dict[Room, tuple[str, ...]] = {
    "inputs": ("materials", "vocabulary", "compared_shots"),
    "runs": ("software", "measurement_versions", "undeclared_numbers"),
}
# Attributes that CF asks of a file: a room has them too, so that it is one by itself.
OF_FILE = ("Conventions", "title", "institution", "source", "history", "references", "comment")


def in_rooms(dataset: xr.Dataset) -> xr.DataTree:
    """The cube as the tree of its file, from the dataset with all variables."""
    refined = {*refinements_of(dataset)}
    rooms: dict[str, xr.Dataset] = {}
    for room in ROOMS:
        names = [str(name) for name, array in dataset.variables.items() if _is_in(array, room, refined)]
        if names or room in ATTRIBUTES:
            rooms[f"/{room}"] = _room(points_of(dataset) if room == ROOT else dataset, names, room)
    return xr.DataTree.from_dict(rooms)


def _is_in(array: xr.Variable, room: Room, refined: set[str]) -> bool:
    """Whether a variable stands in a room: what the root has of a point, ``refinement`` has of each of its grids."""
    own = array.attrs["room"]
    return bool(own == room or (room == "refinement" and own == ROOT and not refined.isdisjoint(array.dims)))


def _room(dataset: xr.Dataset, names: Sequence[str], room: Room) -> xr.Dataset:
    """Some variables along the axes that they have, with the attributes of a file of their own."""
    own = dataset[[name for name in names if name in dataset.variables]]
    axes = [name for name, axis in own.coords.items() if axis.dims and axis.attrs["room"] in (ROOT, "refinement")]
    own = own.drop_vars([name for name in own.coords if name not in (*names, *axes)])
    own = own.reset_coords([name for name in own.coords if room == "inputs" and name in names]).copy()
    elsewhere = {name for names in ATTRIBUTES.values() for name in names}
    kept = {*dataset.attrs} - elsewhere if room == ROOT else {*OF_FILE, *ATTRIBUTES.get(room, ())}
    own.attrs = {name: value for name, value in dataset.attrs.items() if name in kept}
    own.attrs["title"] = ": ".join(filter(None, (dataset.attrs["title"], room)))
    for array in own.variables.values():
        array.attrs = {name: value for name, value in array.attrs.items() if name != "room"}
        if companions := array.attrs.pop("ancillary_variables", "").split():
            array.attrs["ancillary_variables"] = " ".join(name for name in companions if name in own.variables)
    return own


def joined(tree: xr.DataTree) -> xr.Dataset:
    """All variables of a cube in one dataset, from the tree of its file; of each grid where a point has several."""
    variables: dict[Hashable, xr.Variable] = {}
    coordinates: set[Hashable] = set()
    attributes: dict[str, object] = {}
    rooms = {ROOT: tree, **tree.children}
    for room in ROOMS:
        if room not in rooms:
            continue
        own = rooms[room].to_dataset(inherit=False)
        for name, array in own.variables.items():
            if name not in variables or room == "refinement":  # else the coordinate of an axis
                first = variables[name].attrs["room"] if name in variables else room
                variables[name] = array.copy(deep=False)
                variables[name].attrs["room"] = first
        coordinates |= {*(own.variables if room == "inputs" else own.coords)}
        attributes = {**own.attrs, **attributes}
    return xr.Dataset(variables, attrs=attributes).set_coords(coordinates)
