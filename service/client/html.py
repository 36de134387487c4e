"""Sweeps and runs as tables, and films of runs, for notebooks."""

import base64
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

from studies.quantities.display import duration, with_bar
from studies.quantities.units import readable

if TYPE_CHECKING:
    from service.client.connection import Connection
    from service.records.jobs import SweepStatus

DIGITS = 4  # of a measured value


@dataclass(frozen=True)
class Animation:
    """A moving picture; a notebook shows it."""

    gif: bytes

    def _repr_html_(self) -> str:
        return f'<img alt="film of the run" src="data:image/gif;base64,{base64.b64encode(self.gif).decode()}">'

    def save(self, file: str | Path) -> Path:
        """Write it into a file."""
        Path(file).write_bytes(self.gif)
        return Path(file)


class RunDocument(dict[str, Any]):
    """A run as the service describes it; a notebook shows it as a table."""

    def __init__(self, document: Mapping[str, Any], connection: "Connection"):
        super().__init__(document)
        self._connection = connection

    def film(self, field: str = "speed") -> Animation:
        """The film of the run, coloured by a field; raises ServiceError where it was not kept."""
        path = f"/v1/runs/{self['id']}/film.gif"
        return Animation(self._connection.request("GET", path, params={"field": field}).content)

    def _repr_html_(self) -> str:
        rows = [("state", self.get("state")), ("reason", self.get("reason"))]
        rows += [*self._parameters(), *self._measured()]
        return table(f"run {self.get('id', '')[:12]}: {self.get('scenario', '')}", rows)

    def _parameters(self) -> Iterator[tuple[str, str]]:
        """The parameters of the run with their units."""
        from studies import scenarios
        from studies.quantities.parameters import declared

        question = self.get("question") or {}
        parameters = question.get("parameters") or {}
        allowed = declared(scenarios.load(question["scenario"]).parameters) if parameters else {}
        for name, value in parameters.items():
            yield name.replace("_", " "), _with_unit(value, allowed[name].unit if name in allowed else None)

    def _measured(self) -> Iterator[tuple[str, str]]:
        """The measured values of the run with their units."""
        from studies import measurements

        known = set(measurements.names())
        for name, measured in ((self.get("summary") or {}).get("measurements") or {}).items():
            value = _with_unit(measured["value"], measurements.load(name).unit if name in known else None)
            yield name.replace("_", " "), with_bar(value, None) if value else ""


def sweep_table(sweep: "SweepStatus", report: str = "") -> str:
    """A sweep at one moment; ``report`` is the address of its report, if there is one."""
    bar = f'<progress max="1" value="{sweep.progress:.3f}"></progress> {sweep.progress:.0%}'
    rows = [("state", sweep.state), ("runs", sweep.tally), ("reason", sweep.reason), ("renewed", sweep.renewal)]
    rows += [("time left", duration(sweep.eta_seconds or None))]
    link = f'<a href="{escape(report)}">report</a>' if report and sweep.state == "succeeded" else ""
    return table(f"{sweep.name} ({sweep.id[:12]})", rows, below=f"{bar} {link}")


def table(title: str, rows: Iterable[tuple[str, object]], below: str = "") -> str:
    """A table of names and values without those that are None or empty; ``below`` is HTML."""
    lines = "".join(
        f"<tr><th style='text-align: left'>{escape(name)}</th>"
        f"<td style='text-align: left'>{escape(str(value))}</td></tr>"
        for name, value in rows
        if value not in (None, "")
    )
    return f"<div><b>{escape(title)}</b><table>{lines}</table>{below}</div>"


def _with_unit(value: object, unit: str | None) -> str:
    if value is None:
        return ""
    if isinstance(value, bool | str) or unit is None or not isinstance(value, int | float):
        return str(value)
    return readable(float(f"{value:.{DIGITS}g}"), unit)
