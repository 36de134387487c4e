"""Output that several commands share: errors, tables, times."""

import json
import sys
from collections.abc import Iterable, Sequence
from datetime import datetime
from typing import IO, TYPE_CHECKING

from studies.quantities.display import escaped
from studies.quantities.findings import MOST_FINDINGS, InvalidInput
from studies.quantities.units import readable

if TYPE_CHECKING:
    from studies.sweeps.sweep import Sweep

SHORT_ID = 12  # digits of an id in a table; commands take the beginning of an id


def say(text: str, *, file: IO[str] | None = None, flush: bool = False) -> None:
    """Print a text that may hold what a user or a service wrote."""
    print(escaped(text), file=file, flush=flush)


def print_findings(error: InvalidInput) -> None:
    """Print every error with its value, limit and cure."""
    say("whipple: invalid input", file=sys.stderr)
    for finding in error.findings:
        say(f"  {finding.field}", file=sys.stderr)
        for name in ("value", "limit", "cure"):
            say(f"    {name:<6} {getattr(finding, name)}", file=sys.stderr)
    if error.more:
        say(f"  and {error.more} more", file=sys.stderr)
    elif len(error.findings) == MOST_FINDINGS:
        say("  and the rest of the input was not read", file=sys.stderr)


def print_warnings(sweep: "Sweep") -> None:
    """Print the doubts about the points of a sweep to the error stream."""
    from studies.sweeps.warnings import warnings_of

    for warning in warnings_of(sweep):
        say(f"whipple: warning: {warning}", file=sys.stderr)


def print_json(value: object) -> None:
    """Print a value as JSON; times in ISO 8601, sets as sorted lists."""
    say(json.dumps(value, indent=2, default=_plain, ensure_ascii=False))


def _plain(value: frozenset[str] | datetime) -> list[str] | str:
    return sorted(value) if isinstance(value, frozenset) else value.isoformat()


def print_table(columns: Sequence[str], rows: Iterable[Sequence[str]], *, file: IO[str] | None = None) -> None:
    """Print rows below their headings; on a terminal wrapped but for the first column, one line each elsewhere."""
    stream = file or sys.stdout
    if not stream.isatty():
        return _print_lines([[*map(escaped, row)] for row in (columns, *rows)], stream)
    from rich.console import Console
    from rich.table import Column, Table

    first, *others = columns
    # A name or an id is typed by whoever read it.
    typed = Column(first, no_wrap=True, overflow="ignore")
    table = Table(typed, *others, box=None, pad_edge=False, padding=(0, 2, 0, 0))
    for row in rows:
        table.add_row(*map(escaped, row))
    Console(file=stream, markup=False, highlight=False, emoji=False).print(table)


def _print_lines(rows: Sequence[Sequence[str]], stream: IO[str]) -> None:
    """Print a line for each row, its cells below one another: fifty times as fast as rich, for thousands of rows."""
    from rich.cells import cell_len

    widths = [[cell_len(cell) for cell in row] for row in rows]
    widest = [max(column) for column in zip(*widths, strict=True)]
    for row, own in zip(rows, widths, strict=True):
        padded = (cell + " " * (wide - width) for cell, width, wide in zip(row, own, widest, strict=True))
        print("  ".join(padded), file=stream)


def moment(time: datetime | None) -> str:
    """A time in UTC, to the minute; empty for none."""
    return "" if time is None else f"{time:%Y-%m-%d %H:%M}"


def value_with_unit(value: float | str | None, unit: str | None) -> str:
    """A value with its unit, as a sweep document writes it."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if value is None:
        return "none"
    return readable(value, unit) if unit and not isinstance(value, str) else str(value)
