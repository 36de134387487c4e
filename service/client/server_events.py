"""Server-sent events, as a listener reads them: lines into messages."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass


@dataclass(frozen=True)
class ServerEvent:
    """One message of an event stream."""

    name: str  # "message" where the stream gave none
    id: str | None  # of this message; None: it changes nothing for who comes back
    data: str
    retry: float | None = None  # s, after which to come back; told once by a stream


def messages(lines: Iterable[str]) -> Iterator[ServerEvent]:
    """The messages of a stream, comments left out; one that is not ended by an empty line is none.

    >>> [(one.name, one.id, one.data) for one in messages(["id: 7", "data: {}", "", ": awake", "data: half"])]
    [('message', '7', '{}')]
    """
    fields: dict[str, str] = {}
    data: list[str] = []
    for line in lines:
        if line:
            name, _, value = line.partition(":")
            value = value.removeprefix(" ")
            if name == "data":
                data.append(value)
            elif name:
                fields[name] = value
            continue
        if data or "retry" in fields:
            retry = fields.get("retry", "")
            yield ServerEvent(
                name=fields.get("event", "message"),
                id=fields.get("id"),
                data="\n".join(data),
                retry=float(retry) / 1000 if retry.isdigit() else None,
            )
        fields, data = {}, []
