"""The files of a sweep's document: YAML or JSON texts as mappings, and the errors for files that are not there."""

from pathlib import Path
from typing import Any

import yaml

try:  # libyaml's, ten times faster
    from yaml import CSafeLoader as SafeLoader
except ImportError:
    from yaml import SafeLoader  # type: ignore[assignment]  # the same interface in Python

from studies import observations as published
from studies.quantities.findings import Finding, InvalidInput, nearest_cure, refusal, shown
from studies.sweeps import examples

MOST_BESIDE = 20  # files that are compared with the name of a missing one


def read_sweep_file(file: Path) -> dict[str, Any]:
    """The document of a YAML file, with the observations of the CSV file that it may name.

    A name that ships (``studies.observations``) is read where no file of that name is beside the document. Files of
    fitted laws, by their paths from the document, are replaced by their content.

    Raises InvalidInput naming the file: unreadable, not YAML, not a mapping.
    """
    document = read_yaml(_text_of(file, str(file)), str(file))
    table = document.get("observations")
    if isinstance(table, str) and "\n" not in table.strip():
        beside = file.parent / table.strip()
        if beside.exists() or table.strip() not in published.names():
            document["observations"] = _text_of(beside, "observations")
    laws = document.get("laws")
    if isinstance(laws, list):
        document["laws"] = [read_law_file(file.parent / law) if isinstance(law, str) else law for law in laws]
    return document


def read_law_file(file: Path) -> dict[str, Any]:
    """The document of a fitted law, JSON or YAML; raises InvalidInput naming the file.

    Its content is part of a sweep's document: what computes the sweep never opens the file.
    """
    document = read_yaml(_text_of(file, str(file)), str(file), "the file of a fit")
    if "form" not in document:
        cure = "write it with `whipple fit CUBE --form power --out FILE`"
        raise refusal(str(file), "no form", "the file of a fit", cure)
    return document


def read_yaml(text: str, source: str, limit: str = "a mapping with scenario and axes") -> dict[str, Any]:
    """A YAML (or JSON) text as a mapping; raises InvalidInput naming line and column."""
    try:
        document = yaml.load(text, _StrictLoader)
    except (yaml.YAMLError, RecursionError, ValueError, OverflowError) as error:
        problem = " ".join(str(error).split()) or type(error).__name__
        raise InvalidInput([Finding(source, problem, "YAML", "correct the line named")]) from None
    if not isinstance(document, dict):
        raise refusal(source, document, limit, "see the examples")
    return document


class _StrictLoader(SafeLoader):
    """Plain values only, and each key once: the second of two equal keys would win in silence."""

    def construct_mapping(self, node: Any, deep: bool = False) -> dict[Any, Any]:
        keys: set[str] = set()
        for key_node, _ in node.value:
            key = self.construct_object(key_node, deep=True)
            if not isinstance(key, str) or key == "<<":
                continue
            if key in keys:
                problem = f"the key {shown(key)} occurs twice"
                raise yaml.constructor.ConstructorError(None, None, problem, key_node.start_mark)
            keys.add(key)
        return super().construct_mapping(node, deep)


def _text_of(file: Path, name: str) -> str:
    try:
        return file.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise no_such_file(file, name) from None
    except (OSError, UnicodeDecodeError) as error:
        raise InvalidInput([Finding(name, str(file), "a text file that can be read", str(error))]) from None


def no_such_file(file: Path, name: str = "file", example: str = "") -> InvalidInput:
    """The error for a missing file: files beside its place that have its ending, and an example.

    ``example`` says what is wanted, with a path; else it is a sweep, and the cure lists those that ship.
    """
    beside = sorted(other.name for other in file.parent.glob(f"*{file.suffix}"))[:MOST_BESIDE]
    cure = nearest_cure(file.name, beside) if beside else "correct the path."
    if not file.suffix and not cure.startswith("did you mean"):
        cure = "correct the path."
    if example:
        cure = f"{cure} {example}" if cure.startswith("did you mean") else example
    elif file.suffix in (".yaml", ".yml", ".json", ""):
        cure += f" Examples: {', '.join(f'{each}.yaml' for each in examples.names())} in {examples.folder()}"
    return InvalidInput([Finding(name, f"{file}: no such file", "a file that is there", cure)])


def no_such_cube(file: Path) -> InvalidInput:
    """The error for a missing cube."""
    return no_such_file(file, example="give the cube.nc of a sweep, or its folder, such as demo/holes")
