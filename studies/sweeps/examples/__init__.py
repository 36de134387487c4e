"""Sweep files that ship: the main job, and a smoke test.

How to add one: a YAML file in this folder. It is checked by ``tests/studies/sweeps/test_sweep.py``, listed
by ``names()`` and offered by the command line.
"""

from importlib.resources import files

from studies.quantities.findings import nearest_cure, refusal


def names() -> list[str]:
    """The examples that ship, sorted."""
    folder = files(__package__)
    return sorted(file.name.removesuffix(".yaml") for file in folder.iterdir() if file.name.endswith(".yaml"))


def folder() -> str:
    """The folder that holds them."""
    return str(files(__package__))


def text(name: str) -> str:
    """The YAML text of an example; raises InvalidInput with the nearest name."""
    if name not in names():
        raise refusal("example", name, "an example that ships", nearest_cure(name, names()))
    return files(__package__).joinpath(f"{name}.yaml").read_text(encoding="utf-8")
