"""The published numbers of the laws: the doctest examples of each module, run with what they print."""

import doctest
import importlib
import pkgutil
from dataclasses import dataclass
from types import ModuleType
from typing import Any

from studies import laws
from studies.laws import Law


@dataclass(frozen=True)
class Example:
    """One example of a law: what is computed, the published number, and what came out."""

    source: str
    want: str
    got: str
    passed: bool


def module_of(law: Law) -> ModuleType:
    """The module that offers a law, alone or among others."""
    for found in pkgutil.iter_modules(laws.__path__):
        module = importlib.import_module(f"studies.laws.{found.name}")
        offered = getattr(module, "LAW", ())
        if law in (offered if isinstance(offered, tuple) else (offered,)):
            return module
    raise AssertionError(law.name)


def examples_of(law: Law) -> list[Example]:
    """The examples of a law's module that print a number."""
    runner = _Recorder()
    for test in doctest.DocTestFinder(exclude_empty=True).find(module_of(law)):
        runner.run(test, out=lambda text: None)
    return [each for each in runner.examples if each.want]


class _Recorder(doctest.DocTestRunner):
    """Runs examples and keeps what each wants and gives."""

    def __init__(self) -> None:
        super().__init__(verbose=False)
        self.examples: list[Example] = []

    def report_success(self, out: Any, test: Any, example: Any, got: str) -> None:
        self._keep(example, got, passed=True)

    def report_failure(self, out: Any, test: Any, example: Any, got: str) -> None:
        self._keep(example, got, passed=False)

    def report_unexpected_exception(self, out: Any, test: Any, example: Any, exc_info: Any) -> None:
        self._keep(example, repr(exc_info[1]), passed=False)

    def _keep(self, example: Any, got: str, *, passed: bool) -> None:
        mine = Example(example.source.strip(), example.want.strip(), got.strip(), passed)
        self.examples.append(mine)
