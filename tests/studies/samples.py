"""What features offer to the tests that all of their kind share: a folder of tests may have a module ``samples``.

Names that shared tests ask for: ``LAW_SHOTS`` and ``FORMULA_ARGUMENTS`` of laws (``tests/contracts/test_laws.py``).
"""

from functools import cache
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any


@cache
def modules() -> tuple[ModuleType, ...]:
    """The modules of samples."""
    files = sorted(Path(__file__).parent.glob("*/samples.py"))
    return tuple(import_module(f"tests.studies.{file.parent.name}.samples") for file in files)


def offered(name: str) -> list[Any]:
    """What each feature offers under a name."""
    return [getattr(module, name) for module in modules() if hasattr(module, name)]


def joined(name: str, own: dict[Any, Any]) -> dict[Any, Any]:
    """A table with the rows of all features."""
    return own | {key: value for table in offered(name) for key, value in table.items()}
