"""Log of the service: one JSON object a line, on stderr.

``{"time": ..., "level": ..., "logger": ..., "message": ..., "request_id": ..., "run": ...}``. A line that
is written while a request is answered carries its id, from whatever depth; what else a line is about is
given as ``log.info("...", extra=about(lease))``. Only the names of ``FIELDS`` are taken. Of equal warnings and errors
the first is a line, and one with the next warning a minute later says how many more there were.
"""

import json
import logging
import math
import sys
import time
from collections import Counter
from contextlib import nullcontext
from contextvars import ContextVar
from datetime import UTC, datetime
from typing import TextIO

from service.records.jobs import Kind, Lease

FIELDS = (
    "request_id",
    "caller",  # name of the API key
    "method",
    "route",  # the template, not what was asked for
    "status",
    "seconds",
    "run",  # its id, here as in a request
    "sweep",
    "attempt",  # its number
    "worker",
    *("key", "address", "action", "subject", "outcome"),  # of an order: see ``AuditEntry``
)
REPEAT_SECONDS = 60.0  # between two lines about equal warnings
OURS = "service"  # the beginning of the names of the service's loggers
REQUEST_ID: ContextVar[str | None] = ContextVar("request_id", default=None)


class JsonLines(logging.Formatter):
    """A log record as one line, whatever characters its text has."""

    def format(self, record: logging.LogRecord) -> str:
        line: dict[str, str | int | float | None] = {
            "time": datetime.fromtimestamp(record.created, UTC).isoformat(timespec="milliseconds"),
            "level": record.levelname.lower(),
            "logger": record.name,
            "message": record.getMessage(),
            "request_id": REQUEST_ID.get(),
        }
        line |= {name: getattr(record, name) for name in FIELDS if hasattr(record, name)}
        if record.exc_info:
            line["trace"] = self.formatException(record.exc_info)
        return json.dumps({key: value for key, value in line.items() if value is not None}, default=str)


class CountingHandler(logging.StreamHandler[TextIO]):
    """A handler that writes the first of equal warnings, and with a later one the number of the others."""

    def __init__(self, stream: TextIO):
        super().__init__(stream)
        self._written: dict[tuple[str, int, str], float] = {}  # monotonic, by logger, level and text
        self._repeated = Counter[tuple[str, int, str]]()

    def emit(self, record: logging.LogRecord) -> None:
        if record.levelno < logging.WARNING:
            return super().emit(record)
        error = f": {record.exc_info[1]!r}" if record.exc_info else ""
        warning = record.name, record.levelno, f"{record.getMessage()}{error}"
        self._write_counts(time.monotonic() - REPEAT_SECONDS)
        if warning in self._written:
            self._repeated[warning] += 1
        else:
            self._written[warning] = time.monotonic()
            super().emit(record)

    def close(self) -> None:
        """Write what is counted, and close."""
        with self.lock or nullcontext():
            self._write_counts(math.inf)
        super().close()

    def _write_counts(self, before: float) -> None:
        """Write a line for each warning that came again after it was written before a moment, and forget these."""
        for warning in [warning for warning, written in self._written.items() if written <= before]:
            del self._written[warning]
            if count := self._repeated.pop(warning, 0):
                name, level, text = warning
                message = f"{count} times more: {text}"
                super().emit(logging.LogRecord(name, level, "", 0, message, None, None))


def about(lease: Lease) -> dict[str, str | int | None]:
    """Fields of a line about an attempt: its run, or the sweep of a publication."""
    subject = {"run": lease.id} if lease.kind is Kind.RUN else {"sweep": lease.sweep_id}
    return {**subject, "attempt": lease.attempt}


def configure(stream: TextIO | None = None) -> None:
    """Let every logger of this process, and Python's warnings, write JSON lines.

    Other libraries log from ``WARNING`` on, whatever level they set for their own loggers.
    """
    handler = CountingHandler(stream or sys.stderr)
    handler.setFormatter(JsonLines())
    handler.addFilter(_is_worth_a_line)
    logging.basicConfig(handlers=[handler], level=logging.WARNING, force=True)
    logging.getLogger(OURS).setLevel(logging.INFO)
    logging.captureWarnings(True)


def _is_worth_a_line(record: logging.LogRecord) -> bool:
    return record.levelno >= logging.WARNING or record.name.partition(".")[0] == OURS
