"""Rows of verification cases as rows of claims."""

from collections.abc import Iterable, Iterator
from typing import Any

from studies import verification
from studies.values.recipes import RECIPES, Recipe
from tests.claims import Row

DEFAULT = RECIPES["whipple"]


def shown(rows: Iterable[verification.Row], prefix: str = "") -> Iterator[Row]:
    """The same comparisons, with error, tolerance and order in words."""
    for row in rows:
        yield Row(prefix + row.claim, _expected(row), _got(row), row.passed)


def case(name: str, recipe: Recipe = DEFAULT) -> Iterator[Row]:
    """All rows of a case, computed now."""
    return shown(verification.load(name).run(recipe))


def _expected(row: verification.Row) -> Any:
    if isinstance(row.expected, str):
        return row.expected
    words = f"{row.expected:.6g}"
    return words if row.tolerance is None else f"{words}, error at most {row.tolerance:g}"


def _got(row: verification.Row) -> str:
    words = f"{row.got:.6g}"
    if isinstance(row.expected, float):
        words += f" (error {row.error:.2g})"
    return words if row.order is None else f"{words} (order {row.order:.2f})"
