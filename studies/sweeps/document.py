"""The files of a sweep's document: YAML or JSON texts as mappings, and the errors for files that are not there."""

import os
from collections.abc import Hashable, Mapping, Sequence
from pathlib import Path, PurePath
from typing import Any

import yaml

try:  # libyaml's, ten times faster
    from yaml import CSafeLoader as SafeLoader
except ImportError:
    from yaml import SafeLoader  # type: ignore[assignment]  # the same interface in Python

from studies.quantities.arrays import plain
from studies.quantities.findings import MOST_LISTED, Finding, InvalidInput, nearest_cure, refusal, shown
from studies.quantities.parameters import Plain
from studies.quantities.texts import decoded
from studies.sweeps import examples

WIDEST = 10_000  # letters in a line of YAML that is written
MOST_BESIDE = 20  # files that are compared with the name of a missing one


def read_sweep_file(file: Path) -> dict[str, Plain]:
    """The document of a YAML file, with the content of the files that it names; raises InvalidInput."""
    return with_files(read_yaml(text_of(file, str(file)), str(file)), file.parent)


def document_of(source: Mapping[str, Any] | str | Path, *, accuracy: str | float | None = None) -> dict[str, Plain]:
    """The document of a mapping or a file, with an ``accuracy`` in place of its resolution; raises InvalidInput."""
    if isinstance(source, Mapping):
        document = with_files({key: plain(part) for key, part in source.items()}, Path())
    else:
        document = read_sweep_file(Path(source))
    if accuracy is None:
        return document
    return {
        **{key: part for key, part in document.items() if key not in ("resolution", "offsets")},
        "accuracy": accuracy,
    }


def with_files(document: Mapping[str, Plain], folder: Path) -> dict[str, Plain]:
    """A document with the content of the files that it names by their paths from a folder.

    ``observations`` is a table of shots; a file goes before a table that ships (``studies.observations``) of its name.
    ``laws`` are fitted. What came over a network names no file of this machine, and never comes here. Raises
    InvalidInput naming the file.
    """
    document = dict(document)
    table = document.get("observations")
    if isinstance(table, PurePath) or (isinstance(table, str) and "\n" not in table.strip()):
        name = str(table).strip()
        # A name without an ending and without a file is one of a table that ships, or refused as such.
        if isinstance(table, PurePath) or Path(name).suffix or os.path.isfile(folder / name):
            document["observations"] = text_of(folder / name, "observations")
    laws = document.get("laws")
    if isinstance(laws, list):
        document["laws"] = [read_law_file(folder / law) if isinstance(law, str | PurePath) else law for law in laws]
    return document


def read_law_file(file: Path) -> dict[str, Plain]:
    """The document of a fitted law, JSON or YAML, which becomes a part of a sweep's; raises InvalidInput."""
    document = read_yaml(text_of(file, str(file)), str(file), "the file of a fit")
    if "form" not in document:
        cure = "write it with `whipple fit CUBE --form power --out FILE`"
        raise refusal(str(file), "no form", "the file of a fit", cure)
    return document


def read_yaml(text: str, source: str, limit: str = "a mapping with scenario and axes") -> dict[str, Plain]:
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

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Hashable, Plain]:
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


def text_of(file: Path, name: str, example: str = "") -> str:
    """The text of a person's file in its encoding; raises InvalidInput with a field and an example of one."""
    try:
        content = file.read_bytes()
    except FileNotFoundError:
        raise no_such_file(file, name, example) from None
    except (OSError, ValueError) as error:
        raise InvalidInput([Finding(name, shown(str(file)), "a text file that can be read", str(error))]) from None
    return decoded(content, f"{name} ({file.name})" if name != str(file) else name)


def no_such_file(file: Path, name: str = "file", example: str = "") -> InvalidInput:
    """The error for a missing file: near names beside its place, and an example of what is wanted, else of a sweep."""
    beside = sorted(other.name for other in file.parent.glob(f"*{file.suffix}"))[:MOST_BESIDE]
    cure = nearest_cure(file.name, beside) if beside else "correct the path."
    if not file.suffix and not cure.startswith("did you mean"):
        cure = "correct the path."
    if example:
        cure = f"{cure} {example}" if cure.startswith("did you mean") else example
    elif file.suffix in (".yaml", ".yml", ".json", ""):
        names = ", ".join(f"{example}.yaml" for example in examples.names()[:MOST_LISTED])
        cure += f" Examples: {names} in {examples.folder()}"
    return InvalidInput([Finding(name, f"{file}: no such file", "a file that is there", cure)])


def no_such_cube(file: Path) -> InvalidInput:
    """The error for a missing cube."""
    return no_such_file(file, example="give the cube.nc of a sweep, or its folder, such as demo/holes")


# --- documents to read ----------------------------------------------------------------------------


class _Dumper(yaml.SafeDumper):
    """Writes lists and ranges in one line, and texts of several lines as they are."""


def _represent_list(dumper: yaml.SafeDumper, values: Sequence[Plain]) -> yaml.Node:
    is_flat = not any(isinstance(value, dict | list) for value in values)
    return dumper.represent_sequence("tag:yaml.org,2002:seq", values, flow_style=is_flat)


def _represent_mapping(dumper: yaml.SafeDumper, mapping: Mapping[str, Plain]) -> yaml.Node:
    is_range = bool({"start", "low", "limit_of"} & {*mapping})
    return dumper.represent_mapping("tag:yaml.org,2002:map", mapping, flow_style=is_range)


def _represent_text(dumper: yaml.SafeDumper, text: str) -> yaml.Node:
    return dumper.represent_scalar("tag:yaml.org,2002:str", text, "|" if "\n" in text else None)


_Dumper.add_representer(list, _represent_list)
_Dumper.add_representer(dict, _represent_mapping)
_Dumper.add_representer(str, _represent_text)


def yaml_of(document: Plain) -> str:
    """A document as YAML; every line of a text in it is indented."""
    text: str = yaml.dump(document, Dumper=_Dumper, sort_keys=False, allow_unicode=True, width=WIDEST)
    return text
