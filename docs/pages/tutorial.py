"""tutorial.md and cube.md: the cells of each notebook with what they print and draw, executed once.

``python -m docs.pages compute tutorial`` executes them, each notebook in an empty folder, in seconds.
"""

import ast
import contextlib
import io
import os
import re
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from docs.pages import DOCS, RESULTS, keep, read_json

NOTEBOOKS = ("tutorial", "cube")
SILENCED = re.compile(r";(?=\s*(?:#.*)?\Z)")  # the value of the last line, of which a notebook prints nothing


def compute(directory: Path | None = None) -> None:
    """What each cell prints, into ``docs/results``, and the figure that it draws, into docs/gallery."""
    import matplotlib

    matplotlib.use("svg")
    for notebook in NOTEBOOKS:
        namespace: dict[str, Any] = {}
        with tempfile.TemporaryDirectory() as temporary, contextlib.chdir(directory or temporary):
            code = ("".join(cell["source"]) for cell in _cells(notebook) if cell["cell_type"] == "code")
            cells = [_executed(f"{notebook}-{number}", source, namespace) for number, source in enumerate(code)]
        keep({"cells": cells}, RESULTS / f"{notebook}.json")


def _executed(name: str, source: str, namespace: dict[str, Any]) -> dict[str, str]:
    """Output of a cell: what it prints, the value of its last line, and the name of its figure."""
    from matplotlib import pyplot

    from studies.reports.drawing.canvas import drawn_in_style

    *statements, last = ast.parse(source).body
    printed, value = io.StringIO(), None
    with contextlib.redirect_stdout(printed), drawn_in_style("plain"):
        exec(compile(ast.Module(statements, []), "cell", "exec"), namespace)
        if isinstance(last, ast.Expr):
            value = eval(compile(ast.Expression(last.value), "cell", "eval"), namespace)
        else:
            exec(compile(ast.Module([last], []), "cell", "exec"), namespace)
        figure = f"{name}.png" if pyplot.get_fignums() else ""
        if figure:
            pyplot.savefig(DOCS / "gallery" / figure, dpi=110, transparent=True, metadata={"Software": None})
            pyplot.close("all")
    if value is not None and not SILENCED.search(source):
        printed.write(value.to_string() if hasattr(value, "to_string") else repr(value))
    return {"output": printed.getvalue().replace(os.getcwd(), "."), "figure": figure}


def _cells(notebook: str) -> list[dict[str, Any]]:
    return list(read_json(DOCS / f"{notebook}.ipynb")["cells"])


def pages() -> dict[str, str]:
    """The page of each notebook."""
    return {f"{notebook}.md": "\n".join(_parts(notebook)) for notebook in NOTEBOOKS}


def _parts(notebook: str) -> Iterator[str]:
    outputs = iter(read_json(RESULTS / f"{notebook}.json")["cells"])
    for cell in _cells(notebook):
        source = "".join(cell["source"])
        if cell["cell_type"] == "markdown":
            yield f"{source.strip()}\n"
            continue
        yield f"```python\n{SILENCED.sub('', source)}\n```\n"
        kept = next(outputs)
        if kept["output"]:
            yield f"```text\n{kept['output'].rstrip()}\n```\n"
        if kept["figure"]:
            yield f"![What the cell draws](gallery/{kept['figure']})\n"
