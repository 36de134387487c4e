"""Sweep documents that arrive as text: JSON and YAML read strictly, what is wrong named with line and column.

Beyond what the parsers check: a name given twice is refused (the first would be lost without a word), and so
are YAML's references and endless nesting (a short text could stand for a document of any size), and text that
neither a database nor an answer could hold.
"""

import json
import re
from typing import Any

import yaml

from studies import sweep_document
from studies.errors import Finding, InvalidInput
from studies.nearest import shown

DEEPEST = 50  # levels of nesting; a sweep has about five
NO_TEXT = re.compile("[\0\ud800-\udfff]")  # NUL, and halves of characters, as escapes can make them


def read_json(body: bytes) -> Any:
    """What a JSON text says; raises InvalidInput."""
    try:
        return _checked(json.loads(_decoded(body), object_pairs_hook=_unique))
    except json.JSONDecodeError as error:
        place = f"line {error.lineno}, column {error.colno}"
        raise _refusal(place, "a JSON document", f"correct the text there: {error.msg}") from None
    except RecursionError:
        raise _too_deep() from None
    except ValueError as error:  # an integer of thousands of digits
        raise _refusal("a number", "a JSON document", f"shorten it: {error}") from None


def read_yaml(body: bytes) -> Any:
    """What a YAML text says; raises InvalidInput."""
    text = _decoded(body)
    _check_events(text)
    return _checked(sweep_document.read_yaml(text, "document"))


def _decoded(body: bytes) -> str:
    try:
        return body.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = body.count(b"\n", 0, error.start) + 1
        raise _refusal(f"line {line}", "text in UTF-8", "save the text as UTF-8") from None


def _unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) < len(pairs):
        names = [name for name, _ in pairs]
        twice = next(name for name in names if names.count(name) > 1)
        raise _refusal(shown(twice), "each name once", "the name is given twice; remove one")
    return found


def _check_events(text: str) -> None:
    """Refuse references and deep nesting before anything is built.

    PyYAML needs a time that grows with the square of the depth: 43 s for 10 000 levels (2026-11).
    """
    depth = 0
    try:
        for event in yaml.parse(text, yaml.SafeLoader):
            if isinstance(event, yaml.AliasEvent):
                line = f" in line {event.start_mark.line + 1}" if event.start_mark else ""
                raise _refusal(f"*{event.anchor}{line}", "no references", "write the value out")
            depth += isinstance(event, yaml.CollectionStartEvent)
            depth -= isinstance(event, yaml.CollectionEndEvent)
            if depth > DEEPEST:
                raise _too_deep()
    except yaml.YAMLError:
        return  # reading it says what is wrong


def _checked(document: Any) -> Any:
    """The document, if it is not nested deeper than any sweep, and all of its text is text."""
    level = [document]
    for _ in range(DEEPEST):
        for text in filter(_is_no_text, level):
            limit = "text without NUL and without halves of characters"
            raise _refusal(shown(text), limit, "write the character itself, or leave it out")
        level = [part for whole in level for part in _parts(whole)]
        if not level:
            return document
    raise _too_deep()


def _is_no_text(part: Any) -> bool:
    return isinstance(part, str) and NO_TEXT.search(part) is not None


def _parts(whole: Any) -> list[Any]:
    if isinstance(whole, dict):
        return [*whole, *whole.values()]
    return whole if isinstance(whole, list) else []


def _too_deep() -> InvalidInput:
    return _refusal("the nesting", f"at most {DEEPEST} levels", "write a flatter document")


def _refusal(value: str, limit: str, cure: str) -> InvalidInput:
    return InvalidInput([Finding("document", value, limit, cure)])
