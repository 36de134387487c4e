"""Log of the service: one JSON object a line, on stderr.

``{"time": ..., "level": ..., "logger": ..., "message": ..., "request_id": ..., "run": ...}``. A line that
is written while a request is answered carries its id, from whatever depth; what else a line is about is
given as ``log.info("...", extra=about(lease))``. Only the names of ``FIELDS`` are taken.
"""

import json
import logging
import sys
from contextvars import ContextVar
from datetime import UTC, datetime
from typing import Any, TextIO

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
OURS = "service"  # the beginning of the names of the service's loggers
REQUEST_ID: ContextVar[str | None] = ContextVar("request_id", default=None)


class JsonLines(logging.Formatter):
    """A log record as one line, whatever characters its text has."""

    def format(self, record: logging.LogRecord) -> str:
        line: dict[str, Any] = {
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


def about(lease: Lease) -> dict[str, Any]:
    """Fields of a line about an attempt: its run, or the sweep of a publication."""
    subject = {"run": lease.id} if lease.kind is Kind.RUN else {"sweep": lease.sweep_id}
    return {**subject, "attempt": lease.attempt}


def configure(stream: TextIO | None = None) -> None:
    """Let every logger of this process, and Python's warnings, write JSON lines.

    Other libraries log from ``WARNING`` on, whatever level they set for their own loggers.
    """
    handler = logging.StreamHandler(stream or sys.stderr)
    handler.setFormatter(JsonLines())
    handler.addFilter(_is_worth_a_line)
    logging.basicConfig(handlers=[handler], level=logging.WARNING, force=True)
    logging.getLogger(OURS).setLevel(logging.INFO)
    logging.captureWarnings(True)


def _is_worth_a_line(record: logging.LogRecord) -> bool:
    return record.levelno >= logging.WARNING or record.name.partition(".")[0] == OURS
