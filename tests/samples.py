"""What features offer to the tests that all of their kind share: a folder of tests may have a module ``samples``.

Names that shared tests ask for: ``LAW_SHOTS`` and ``FORMULA_ARGUMENTS`` of laws (``tests/contracts/test_laws.py``) and
``QUESTION`` to them, ``SMALL``, ``RESOLUTION``, ``VARIED`` and ``COMPILED_ALONE`` of scenarios
(``tests/contracts/test_scenarios.py``), ``STATES``, ``FOLLOWED``, ``KNOWN``, ``NO_VALUE`` and ``DOUBTED`` of
measurements (``tests/studies/measurements``), ``SOLVED``, ``CASES``, ``LONG`` and ``OF_LONGER_RUNS`` of runs
(``tests/studies/runs``), and ``REFUSED`` of parameters. Of the solver ``PROBLEMS`` and ``LONG``
(``tests/solver/test_checkpoint.py``).
"""

from collections.abc import Mapping
from functools import cache
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from solver.steppers import methods
from studies import scenarios

DIAMETER, CELLS = 8e-3, 4.0
SHOT = {
    "speed": 3000.0,
    "projectile_diameter": DIAMETER,
    "projectile": "copper-ofhc",
    "target": "copper-ofhc",
    "cells_per_diameter": CELLS,
}
CYLINDER: dict[str, Any] = {"projectile_shape": "cylinder", "projectile_length": 0.75 * DIAMETER}
ANY: tuple[dict[str, Any], ...] = ({"courant": 0.9}, {"particles_per_cell": 1}, {"particles_per_cell": 4})


@cache
def modules(floor: str = "studies") -> tuple[ModuleType, ...]:
    """The modules of samples of a floor."""
    files = sorted(Path(__file__).parent.glob(f"{floor}/*/samples.py"))
    return tuple(import_module(f"tests.{floor}.{file.parent.name}.samples") for file in files)


def offered(name: str, floor: str = "studies") -> list[Any]:
    """What each feature offers under a name."""
    return [getattr(module, name) for module in modules(floor) if hasattr(module, name)]


def joined(name: str, own: dict[Any, Any], floor: str = "studies") -> dict[Any, Any]:
    """A table with the rows of all features."""
    return own | {key: value for table in offered(name, floor) for key, value in table.items()}


def is_there(scenario: str, changes: Mapping[str, Any]) -> bool:
    """Whether a scenario, and the method that parameters name, are installed."""
    return scenario in scenarios.names() and changes.get("method", "mpm") in methods()


def needs(*names: str) -> pytest.MarkDecorator:
    """The mark of a test that takes the scenarios, or methods, of features as its example: skipped without them."""
    missing = {*names} - {*scenarios.names(), *methods()}
    return pytest.mark.skipif(bool(missing), reason=f"no {', '.join(sorted(missing))}")
