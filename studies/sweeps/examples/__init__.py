"""Sweep files that ship: the main job, and a smoke test.

How to add one: a YAML file in this folder, or in one that a feature names through the entry-point group
``whipple.studies.sweeps.examples``. It is checked by ``tests/studies/sweeps/test_sweep.py``, listed by ``names()`` and
offered by the command line.
"""

from functools import cache
from importlib.resources import files
from importlib.resources.abc import Traversable

from solver.registry import folders
from studies.quantities.findings import nearest_cure, refusal


@cache
def _files() -> dict[str, Traversable]:
    """The file of each example, by its name."""
    every = {file.name.removesuffix(".yaml"): file for place in folders(__package__) for file in files(place).iterdir()}
    return {name: file for name, file in sorted(every.items()) if file.name.endswith(".yaml")}


def names() -> list[str]:
    """The examples that ship, sorted."""
    return list(_files())


def folder() -> str:
    """The folder that holds most of them."""
    return str(files(__package__))


def text(name: str) -> str:
    """The YAML text of an example; raises InvalidInput with the nearest name."""
    if name not in _files():
        raise refusal("example", name, "an example that ships", nearest_cure(name, names()))
    return _files()[name].read_text(encoding="utf-8")
