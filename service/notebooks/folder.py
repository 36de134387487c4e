"""Tables and moving pictures for notebooks: a sweep as it stands, and the folder of one that was computed here."""

import base64
import json
from collections.abc import Iterable
from dataclasses import dataclass
from html import escape
from pathlib import Path, PosixPath
from typing import TYPE_CHECKING

from solver.registry import points
from studies.quantities.display import duration
from studies.quantities.files import CUBE, REPORT_HTML, REPORT_JSON
from studies.quantities.findings import MissingExtra

if TYPE_CHECKING:
    from service.records.jobs import SweepStatus
    from studies.cubes.opening import DataTree
    from studies.notebooks.figures import Figures


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


class SweepFolder(PosixPath):
    """The folder with the results of a sweep, a path as any other; a notebook shows what its report says."""

    def with_segments(self, *segments: "str | Path") -> Path:  # what is inside is a plain path
        return Path(*segments)

    def _repr_html_(self) -> str | None:
        report = Path(self, REPORT_JSON)
        if not report.is_file():
            return None
        document = json.loads(report.read_bytes())
        rows = [
            ("headline", document["headline"]),
            ("runs", len(document["runs"]["runs"])),
            ("report", Path(self, REPORT_HTML)),
        ]
        return table(document["title"], rows)

    def open_cube(self) -> "DataTree":
        """The cube, as it is looked at; raises InvalidInput where there is none."""
        import studies.notebooks.figures  # noqa: F401 # its figures: cube.whipple
        from studies.cubes.opening import open_tree

        return open_tree(Path(self, CUBE))

    def plot(self) -> "Figures":
        """The figures of the report."""
        with self.open_cube() as cube:
            return cube.whipple.plot()

    def film(self, run: str = "", field: str = "speed") -> Animation:
        """The film of a run, by default of the first one, of a sweep that kept films.

        ``run`` is the beginning of its id. Raises InvalidInput.
        """
        for point in points("service.notebooks").select(name="film"):
            return Animation(point.load()(Path(self), run, field))
        raise MissingExtra("nothing that makes films is installed")


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
