"""api.md: what Python programs call, from signatures, docstrings and the comments beside fields."""

import importlib
import inspect
import re
from collections.abc import Iterator
from dataclasses import is_dataclass
from enum import Enum
from typing import Any

PARAGRAPH = "\n\n"
# Modules and the names of each that are documented; none: those of ``__all__``.
MODULES: dict[str, tuple[str, ...]] = {
    "whipple": (),
    "service.client.client": ("SweepHandle",),
    "service.notebooks.folder": ("SweepFolder",),
    "studies.notebooks.figures": ("CubeAccessor", "Figures"),
    "studies.laws": ("names", "load", "answering", "shot_from", "Shot", "Law", "LawValue", "Reason", "in_words"),
    "studies.shields.shield": ("Shield", "FurtherBumper", "ShotAtShield"),
    "studies.answers.question": ("read_question", "Question", "ShotParameters"),
    "studies.answers.answer": ("answers", "ShotAnswer", "QuantityAnswer", "LawAnswer"),
    "studies.answers.cube": ("cube_of",),
    "solver.simulation": ("simulate", "Outcome", "Snapshot"),
    "solver.problem": ("Problem", "Body", "Face", "StepRule", "ArtificialViscosity"),
}
PATH = re.compile(r"\b(?:[A-Za-z_]\w*\.)+(?=[A-Za-z_])")  # of a module before a name
QUOTED = re.compile(r"(?<=[:>] )'([^']+)'")  # a type that is imported when it is needed
# Between the docstring of a class and its first method.
FIELDS = re.compile(r'^    """.*?"""\n(.*?)(?=^    (?:def|@)|\Z)', re.MULTILINE | re.DOTALL)


def pages() -> dict[str, str]:
    """api.md."""
    parts = [
        "# Calling whipple from Python\n",
        "`whipple` is what notebooks and scripts need; the modules below it are for programs that want single laws, an "
        "answer without a run, or [the solver by itself](solver.md). All numbers are in SI. A service documents REST "
        "itself, at `/docs`.\n",
    ]
    for name, chosen in MODULES.items():
        module = importlib.import_module(name)
        parts += [f"## {name}\n", f"{_prose(module).partition(PARAGRAPH)[0]}\n"]
        for each in chosen or module.__all__:
            parts += list(_entry(each, getattr(module, each)))
    return {"api.md": "\n".join(parts)}


def _entry(name: str, offered: Any) -> Iterator[str]:
    yield f"### {name}\n"
    if not inspect.isclass(offered):
        yield f"```text\n{name}{_signature(offered)}\n```\n"
        yield f"{_prose(offered)}\n"
        return
    yield f"{_prose(offered)}\n"
    if fields := _fields(offered):
        yield f"```text\n{fields}\n```\n"
    for called, member in vars(offered).items():
        if (
            not called.startswith("_")
            and (inspect.isfunction(member) or isinstance(member, property))
            and member.__doc__
        ):
            signature = "" if isinstance(member, property) else _signature(member)
            yield f"- `{called}{signature}`: {_prose(member).partition(PARAGRAPH)[0].replace(chr(10), ' ')}"
    yield ""


def _signature(function: Any) -> str:
    """Its parameters and what it returns, each type by its own name."""
    text = PATH.sub("", QUOTED.sub(r"\1", str(inspect.signature(function))))
    return text.replace("(self, ", "(").replace("(self)", "()")


def _prose(documented: Any) -> str:
    """A docstring as Markdown, without its examples."""
    text = inspect.getdoc(documented) or ""
    return text.partition("\n\n>>> ")[0].replace("``", "`")


def _fields(record: type) -> str:
    """The lines of a record's fields, or of an enumeration's members, as they stand, with their comments."""
    if not (is_dataclass(record) or issubclass(record, tuple | Enum)):
        return ""
    found = FIELDS.search(inspect.getsource(record))
    return inspect.cleandoc(found[1]) if found else ""
