"""Materials: constants of matter as data, each number with unit, source and confidence.

How to add one: a TOML file in this folder, named after the material; nothing else. Copy the nearest
one and change every number together with its source. Each number is ``{value, unit, source,
confidence}``; the words of ``confidence`` are in ``schema.CONFIDENCES``. Where a model goes without
a number that it could have (no melting, no limit in tension), write ``value = "none"`` and the
source of that choice. ``yield_stresses`` lists the published values that a law may be evaluated
with. Another distribution adds one through an entry point of the group
``whipple.studies.materials``, named after the material, whose value is the package that holds the
file. ``tests/contracts/test_materials.py`` finds it.

A user's material is the same schema inside a sweep; there a number may stand alone with its unit
(``A = "900 MPa"``: then the user is its source), and ``base`` names a shipped material that gives all else.
"""

import tomllib
from collections.abc import Mapping
from decimal import Decimal
from functools import cache
from importlib.resources import files
from importlib.resources.abc import Traversable

from solver.registry import points
from studies.materials.reader import read_document
from studies.materials.schema import CONFIDENCES, Material, Model
from studies.quantities.findings import nearest_cure, refusal
from studies.quantities.parameters import Plain, join

__all__ = ["CONFIDENCES", "Material", "Model", "load", "names", "read_own"]


def names() -> list[str]:
    """The materials that ship, sorted."""
    return list(_folders())


@cache
def load(name: str) -> Material:
    """A material that ships; raises InvalidInput with the nearest name, or with every finding in its file."""
    if name not in _folders():
        raise refusal("material", name, "a material that ships", nearest_cure(name, _folders()))
    file = f"{name}.toml"
    text = _folders()[name].joinpath(file).read_text(encoding="utf-8")
    return read_document(tomllib.loads(text, parse_float=Decimal), name=name, path=file)


def read_own(document: Plain, path: str = "", name: str | None = None) -> Material:
    """A user's material, upon the shipped one that it may name as its ``base``; raises InvalidInput below ``path``."""
    if not isinstance(document, Mapping) or "base" not in document:
        return read_document(document, name=name, path=path)
    base, changes = document["base"], {k: v for k, v in document.items() if k != "base"}
    if not isinstance(base, str) or base not in _folders():
        raise refusal(join(path, "base"), base, "a material that ships", nearest_cure(base, _folders()))
    return read_document(changes, name=name, path=path, base=load(base))


@cache
def _folders() -> Mapping[str, Traversable]:
    """The folder of each material that ships, by name."""
    here = files(__package__)
    shipped = (file.name for file in here.iterdir())
    folders = {name.removesuffix(".toml"): here for name in shipped if name.endswith(".toml")}
    folders |= {point.name: files(point.value) for point in points(__package__)}
    return dict(sorted(folders.items()))
