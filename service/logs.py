"""Log of the service: one JSON object a line, on stderr.

``{"time": ..., "level": ..., "logger": ..., "message": ..., "request_id": ..., "run": ...}``. A line that
is written while a request is answered carries its id, from whatever depth; what else a line is about is
given as ``log.info("...", extra=about(lease))``. Only the names of ``FIELDS`` are taken. Of equal warnings and errors
the first is a line, and then one a minute says how many more there were.
"""

import json
import logging
import sys
import threading
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
    """A handler that writes the first of equal warnings, and then from time to time the number of the others."""

    def __init__(self, stream: TextIO):
        super().__init__(stream)
        self._repeated: dict[tuple[str, int, str], int] = {}  # since the last look, by logger, level and text
        self._timer: threading.Timer | None = None

    def emit(self, record: logging.LogRecord) -> None:
        if record.levelno < logging.WARNING:
            return super().emit(record)
        error = f": {record.exc_info[1]!r}" if record.exc_info else ""
        warning = record.name, record.levelno, f"{record.getMessage()}{error}"
        if warning in self._repeated:
            self._repeated[warning] += 1
        else:
            self._repeated[warning] = 0
            super().emit(record)
        if self._timer is None:
            self._look_later()

    def close(self) -> None:
        """Write what is counted, and close."""
        self.acquire()
        try:
            if self._timer is not None:
                self._timer.cancel()
            self._write_counts()
            self._repeated.clear()
        finally:
            self.release()
        super().close()

    def _look_later(self) -> None:
        self._timer = threading.Timer(REPEAT_SECONDS, self._look)
        self._timer.daemon = True
        self._timer.start()

    def _look(self) -> None:
        """Write what is counted, and forget warnings that did not come again."""
        self.acquire()
        try:
            self._timer = None
            self._repeated = dict.fromkeys(self._write_counts(), 0)
            if self._repeated:
                self._look_later()
        finally:
            self.release()

    def _write_counts(self) -> list[tuple[str, int, str]]:
        """Write a line for each warning that came again; return these."""
        again = [warning for warning, count in self._repeated.items() if count]
        for name, level, text in again:
            message = f"{self._repeated[name, level, text]} times more: {text}"
            super().emit(logging.LogRecord(name, level, "", 0, message, None, None))
        return again


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
