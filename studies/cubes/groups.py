"""A cube as the tree of its file, xarray's ``DataTree``, and as one dataset.

The root has the axes and what a person reads first, of each point; ``laws``, ``observations``, ``refinement`` (every
grid and offset), ``quantities``, ``runs`` and ``inputs`` have the rest, on the axes of the root and on dimensions of
their own. A variable states its group where it is declared. Whipple itself works with all variables in one dataset.
"""

from collections.abc import Hashable, Sequence

import xarray as xr

from studies.cubes.points import points_of, refinements_of
from studies.cubes.variable import GROUPS, ROOT, Group

# Attributes of one group, for programs; all others stand at the root.
ATTRIBUTES: dict[Group, tuple[str, ...]] = {
    "inputs": ("materials", "vocabulary", "compared_shots"),
    "runs": ("software", "measurement_versions", "undeclared_numbers"),
}
# Attributes that CF asks of a file: a group has them too, so that it is one by itself.
OF_FILE = ("Conventions", "title", "institution", "source", "history", "references", "comment")


def as_tree(dataset: xr.Dataset) -> xr.DataTree:
    """The cube as the tree of its file, from the dataset with all variables."""
    refined = {*refinements_of(dataset)}
    groups: dict[str, xr.Dataset] = {}
    for group in GROUPS:
        names = [str(name) for name, array in dataset.variables.items() if _is_in(array, group, refined)]
        if names or group in ATTRIBUTES:
            groups[f"/{group}"] = _group(points_of(dataset) if group == ROOT else dataset, names, group)
    return xr.DataTree.from_dict(groups)


def _is_in(array: xr.Variable, group: Group, refined: set[str]) -> bool:
    """Whether a variable stands in a group: what the root has of a point, ``refinement`` has of each of its grids."""
    own = array.attrs["group"]
    return bool(own == group or (group == "refinement" and own == ROOT and not refined.isdisjoint(array.dims)))


def _group(dataset: xr.Dataset, names: Sequence[str], group: Group) -> xr.Dataset:
    """Some variables along the axes that they have, with the attributes of a file of their own."""
    own = dataset[[name for name in names if name in dataset.variables]]
    axes = [name for name, axis in own.coords.items() if axis.dims and axis.attrs["group"] in (ROOT, "refinement")]
    own = own.drop_vars([name for name in own.coords if name not in (*names, *axes)])
    own = own.reset_coords([name for name in own.coords if group == "inputs" and name in names]).copy()
    elsewhere = {name for names in ATTRIBUTES.values() for name in names}
    kept = {*dataset.attrs} - elsewhere if group == ROOT else {*OF_FILE, *ATTRIBUTES.get(group, ())}
    own.attrs = {name: value for name, value in dataset.attrs.items() if name in kept}
    own.attrs["title"] = ": ".join(filter(None, (dataset.attrs["title"], group)))
    for array in own.variables.values():
        array.attrs = {name: value for name, value in array.attrs.items() if name != "group"}
        companions = array.attrs.pop("ancillary_variables", "").split()
        if there := [name for name in companions if name in own.variables]:
            array.attrs["ancillary_variables"] = " ".join(there)
    return own


def joined(tree: xr.DataTree) -> xr.Dataset:
    """All variables of a cube in one dataset, from the tree of its file; of each grid where a point has several."""
    variables: dict[Hashable, xr.Variable] = {}
    coordinates: set[Hashable] = set()
    attributes: dict[str, object] = {}
    groups = {ROOT: tree, **tree.children}
    for group in GROUPS:
        if group not in groups:
            continue
        own = groups[group].to_dataset(inherit=False)
        for name, array in own.variables.items():
            if name not in variables or group == "refinement":  # else the coordinate of an axis
                known = variables[name].attrs if name in variables else {"group": group}
                variables[name] = array.copy(deep=False)
                variables[name].attrs |= known
        coordinates |= {*(own.variables if group == "inputs" else own.coords)}
        attributes = {**own.attrs, **attributes}
    return xr.Dataset(variables, attrs=attributes).set_coords(coordinates)
