"""Pages of the documentation that are made, from what the project ships and from results that were computed once.

``make docs`` builds them into build/site with the pages of docs/. ``python -m docs.pages compute NAME`` computes the
results behind a page anew, in seconds (``tutorial``) or hours (``shots``, ``verification``, ``validation``).

How to add a page: a module here that offers ``pages()``, Markdown by the name of its file among those of docs/, and,
where the page has plots, ``drawings()``, SVG by name of file in drawings/.
"""

import json
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from functools import cache
from importlib import import_module
from itertools import groupby
from multiprocessing import get_context
from pathlib import Path
from pkgutil import iter_modules
from tempfile import TemporaryDirectory
from types import ModuleType
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from studies.quantities.files import RESULT
from studies.runs.execution import execute
from studies.runs.results import RunResult
from studies.runs.run import Run

DOCS = Path(__file__).parents[1]
RESULTS = DOCS / "results"
WORKERS = 2  # processes that compute runs
FEWEST = 3  # rows that stand below one with their place
KeptRow = Mapping[str, Any]  # a row of a comparison as plain objects, as ``docs/results`` keeps it
DIGITS = 8  # of numbers that are kept for a page, which shows fewer


@cache
def made() -> Mapping[str, str]:
    """Every page and drawing that is made, by the name of its file among those of docs/."""
    texts: dict[str, str] = {}
    for module in modules().values():
        texts |= module.pages() if hasattr(module, "pages") else {}
        drawings = module.drawings() if hasattr(module, "drawings") else {}
        texts |= {f"drawings/{file}": text for file, text in drawings.items()}
    return texts


def modules() -> Mapping[str, ModuleType]:
    """The modules of pages by their names."""
    names = [found.name for found in iter_modules(__path__) if found.name not in ("__main__", "site")]
    return {name: import_module(f"{__name__}.{name}") for name in names}


def in_markdown(name: str, **told: Any) -> str:
    """A page by its template, a Markdown file of this folder."""
    environment = Environment(
        loader=FileSystemLoader(Path(__file__).parent), undefined=StrictUndefined, trim_blocks=True
    )
    return re.sub(r"\n{3,}", "\n\n", environment.get_template(f"{name}.md").render(**told)) + "\n"


def table(header: list[str], rows: list[list[str]]) -> str:
    """A table of Markdown."""
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in lines) + "\n"


def by_place(rows: Sequence[list[str]]) -> Iterator[list[str]]:
    """Rows whose first cells begin alike, up to their last colon, below a row with that beginning alone."""
    for place, mine in groupby(rows, lambda row: row[0].rpartition(": ")[0]):
        group = list(mine)
        if place and len(group) >= FEWEST:
            yield [f"**{place}**", *[""] * (len(group[0]) - 1)]
            group = [[what.removeprefix(f"{place}: "), *rest] for what, *rest in group]
        yield from group


def keep(document: Any, file: Path) -> None:
    """Write results, each innermost object on a line of its own."""
    text = json.dumps(document, indent=1, ensure_ascii=False)
    innermost = re.compile(r"\{[^{}]*(?:\{[^{}]*\}[^{}]*)?\}")
    lines = innermost.sub(lambda match: re.sub(r"\n\s*", " ", match[0]), text)
    file.parent.mkdir(exist_ok=True)
    file.write_text(lines + "\n", encoding="utf-8")


def read_json(file: Path) -> Any:
    """Results as they were kept."""
    return json.loads(file.read_text(encoding="utf-8"))


def computed_rows(
    row_of: Callable[[Any, Path], KeptRow], places: Iterable[Any], directory: Path | None
) -> Iterator[KeptRow]:
    """Rows of ``row_of`` at each place, as they are computed; runs that the directory has are read from it."""
    with TemporaryDirectory() as temporary, ProcessPoolExecutor(WORKERS, mp_context=get_context("spawn")) as pool:
        folder = (directory or Path(temporary)).resolve()
        for computing in as_completed([pool.submit(row_of, place, folder) for place in places]):
            yield computing.result()


def computed_once(run: Run, directory: Path) -> RunResult:
    """The result of a run, computed where its directory has none, and from where it was cut."""
    file = directory / RESULT
    if not file.exists():
        directory.mkdir(parents=True, exist_ok=True)
        execute(run, directory, threads=1, checkpoint=directory / "checkpoint")
    return RunResult.from_json(read_json(file))


def cell(text: str) -> str:
    """A text in a table of Markdown."""
    return text.replace("|", "\\|")


def plain(stated: Mapping[str, Any]) -> KeptRow:
    """A row of a comparison without its verdict and without empty fields."""
    return {name: short(value) for name, value in stated.items() if name != "verdict" and value not in (None, "", {})}


def short(value: Any, digits: int = DIGITS) -> Any:
    """Numbers with so many digits."""
    if isinstance(value, dict):
        return {name: short(each, digits) for name, each in value.items()}
    return float(f"{value:.{digits}g}") if isinstance(value, float) else value


def counted(rows: Sequence[KeptRow]) -> str:
    """How many of the gates of kept rows hold."""
    gates = [row["passed"] for row in rows if "passed" in row]
    return f"{sum(gates)} of {len(gates)}" if gates else "no"
