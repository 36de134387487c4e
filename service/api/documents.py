"""Strict readers of sweep documents in JSON and YAML, which report line and column of an error.

They also refuse repeated names (the first value would be lost silently), YAML's references, deep nesting (a short text
could expand without bound) and tags, and text that a database or a response cannot hold. 4 MB take less than a second.
"""

import json
import re
from collections import Counter
from collections.abc import Iterable

import yaml

from studies.quantities.findings import Finding, InvalidInput, shown
from studies.quantities.parameters import Plain
from studies.quantities.texts import strictly_decoded
from studies.sweeps import document as sweep_document

DEEPEST = 50  # levels of nesting; a sweep has about five
LONGEST_NAME = 200  # characters of a key; those of a sweep have less than fifty
MOST_BRACKETS = 100_000  # opening brackets in JSON; ten thousand observations have ten thousand
MOST_YAML_VALUES = 50_000  # each takes 8 us, in JSON 0.1 us (2026-11)
# Characters of an unquoted YAML value; parsing one like 1:30:00 as a number takes quadratic time.
LONGEST_PLAIN = 1_000
CHECKED_TYPES = frozenset({dict, list, str})
INVALID_TEXT = re.compile("[\0\ud800-\udfff]")  # NUL and lone surrogates, which escapes can produce


def read_json(body: bytes) -> Plain:
    """The document in a JSON text; raises InvalidInput."""
    text = strictly_decoded(body, "document")
    _check_brackets(text)
    try:
        document: Plain = json.loads(text, object_pairs_hook=_unique)
        _check(document)
        return document
    except json.JSONDecodeError as error:
        position = f"line {error.lineno}, column {error.colno}"
        raise _refusal(position, "a JSON document", f"correct the syntax: {error.msg}") from None
    except RecursionError:
        raise _too_deep() from None
    except ValueError as error:  # an integer of thousands of digits
        raise _refusal("a number", "a JSON document", f"shorten it: {error}") from None


def read_yaml(body: bytes, limit: str = "a mapping with scenario and axes") -> dict[str, Plain]:
    """The mapping in a YAML text, of which ``limit`` says what it has; raises InvalidInput."""
    text = strictly_decoded(body, "document")
    _check_events(text)
    document: dict[str, Plain] = sweep_document.read_yaml(text, "document", limit)
    _check(document)
    return document


def _check_brackets(text: str) -> None:
    """Refuse too many lists and mappings before building any: each costs ten times as much as a number."""
    count = text.count("[") + text.count("{")
    if count > MOST_BRACKETS:
        cure = "use fewer, or write the observations as one CSV text"
        raise _refusal(f"{count} brackets", f"at most {MOST_BRACKETS} opening brackets", cure)


def _unique(pairs: list[tuple[str, Plain]]) -> dict[str, Plain]:
    mapping = dict(pairs)
    if len(mapping) < len(pairs):
        names = Counter(name for name, _ in pairs)
        repeated = next(name for name, count in names.items() if count > 1)
        raise _refusal(shown(repeated), "each name once", "the name is given twice; remove one")
    return mapping


def _check_events(text: str) -> None:
    """Refuse references, tags, deep nesting and too many values before building anything."""
    depth = values = 0
    try:
        for event in yaml.parse(text, sweep_document.SafeLoader):
            if isinstance(event, yaml.NodeEvent):
                _check_node(event)
                values += 1
            depth += isinstance(event, yaml.CollectionStartEvent)
            depth -= isinstance(event, yaml.CollectionEndEvent)
            if depth > DEEPEST:
                raise _too_deep()
            if values > MOST_YAML_VALUES:
                cure = "send JSON, or write the observations as one CSV text"
                raise _refusal("too many values", f"at most {MOST_YAML_VALUES} values in YAML", cure)
    except yaml.YAMLError:
        return  # the reader reports the error


def _check_node(event: yaml.NodeEvent) -> None:
    """Refuse a value that is a reference, has a tag, or is long and unquoted."""
    line = f" in line {event.start_mark.line + 1}" if event.start_mark else ""
    if isinstance(event, yaml.AliasEvent):
        raise _refusal(f"*{shown(event.anchor)}{line}", "no references", "write the value out")
    if isinstance(event, yaml.ScalarEvent | yaml.CollectionStartEvent) and event.tag is not None:
        raise _refusal(f"{shown(event.tag)}{line}", "no tags", "write the value alone")
    if isinstance(event, yaml.ScalarEvent) and event.implicit[0] and len(event.value) > LONGEST_PLAIN:
        limit = f"at most {LONGEST_PLAIN} characters without quotes"
        raise _refusal(f"{shown(event.value)}{line}", limit, "put quotes around it, or shorten it")


def _check(document: Plain) -> None:
    """Refuse a document that is too deep, has long names, or text that nothing can hold."""
    level = [document]
    for _ in range(DEEPEST):
        mappings = [part for part in level if isinstance(part, dict)]
        names = [name for mapping in mappings for name in mapping if isinstance(name, str)]
        for name in names:
            if len(name) > LONGEST_NAME:
                raise _refusal(shown(name), f"a name of at most {LONGEST_NAME} characters", "shorten the name")
        _check_text(names + [part for part in level if isinstance(part, str)])
        containers: list[Iterable[Plain]] = [part for part in level if isinstance(part, list)]
        containers += [mapping.values() for mapping in mappings]
        level = [part for parts in containers for part in parts if type(part) in CHECKED_TYPES]
        if not level:
            return
    raise _too_deep()


def _check_text(texts: list[str]) -> None:
    if not INVALID_TEXT.search("".join(texts)):
        return
    invalid = next(text for text in texts if INVALID_TEXT.search(text))
    limit = "text without NUL and without lone surrogates"
    raise _refusal(shown(invalid), limit, "write the character itself, or remove it")


def _too_deep() -> InvalidInput:
    return _refusal("the nesting", f"at most {DEEPEST} levels", "write a flatter document")


def _refusal(value: str, limit: str, cure: str) -> InvalidInput:
    return InvalidInput([Finding("document", value, limit, cure)])


def pointer(field: str, document: Plain) -> str:
    """The JSON pointer (RFC 6901) of the deepest part of ``document`` that a finding's field names.

    >>> pointer("axes.speed[1]", {"axes": {"speed": ["2 km/s", "6"]}})
    '/axes/speed/1'
    >>> pointer("fixed.target.strength.A", {"fixed": {"target.strength.A": 100}})
    '/fixed/target.strength.A'
    >>> pointer("fixed.speed", {"fixed": {}})
    '/fixed'
    """
    path, rest, part = "", field, document
    while rest and (step := _step(rest, part)) is not None:
        key, part, length = step
        path += "/" + key.replace("~", "~0").replace("/", "~1")
        rest = rest[length:].removeprefix(".")
    return path


def _step(field: str, part: Plain) -> tuple[str, Plain, int] | None:
    """The longest key of ``part`` that ``field`` begins with, the part under it, and the key's length in the field."""
    if isinstance(part, list) and (match := re.match(r"\[(\d{1,9})\]", field)):
        index = int(match[1])
        return (match[1], part[index], match.end()) if index < len(part) else None
    if isinstance(part, dict):
        ends = [len(field), *(match.start() for match in re.finditer(r"[.[]", field))]
        lengths = sorted((end for end in ends if end and field[:end] in part), reverse=True)
        return next(((field[:length], part[field[:length]], length) for length in lengths), None)
    return None
