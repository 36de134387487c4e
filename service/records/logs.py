"""What the service says of itself: one JSON object a line, on stderr.

``{"time": ..., "level": ..., "logger": ..., "message": ..., "request_id": ..., "run": ...}``. A line that
is written while a request is answered carries its id, from whatever depth; what else a line is about is
given as ``log.info("...", extra=about(claim))``. Only the names of ``FIELDS`` are taken.
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
)
OURS = "service"  # the begin of our loggers' names
REQUEST_ID: ContextVar[str | None] = ContextVar("request_id", default=None)


class JsonLines(logging.Formatter):
    """A record as one line, whatever its text holds."""

    def format(self, record: logging.LogRecord) -> str:
        words: dict[str, Any] = {
            "time": datetime.fromtimestamp(record.created, UTC).isoformat(timespec="milliseconds"),
            "level": record.levelname.lower(),
            "logger": record.name,
            "message": record.getMessage(),
            "request_id": REQUEST_ID.get(),
        }
        words |= {name: getattr(record, name) for name in FIELDS if hasattr(record, name)}
        if record.exc_info:
            words["trace"] = self.formatException(record.exc_info)
        return json.dumps(
            {key: value for key, value in words.items() if value is not None}, default=str
        )


def about(claim: Lease) -> dict[str, Any]:
    """What a line is about that tells of an attempt: its run, or the sweep of a publication."""
    subject = {"run": claim.id} if claim.kind is Kind.RUN else {"sweep": claim.sweep_id}
    return {**subject, "attempt": claim.attempt}


def configure(stream: TextIO | None = None) -> None:
    """Let every logger of this process, and Python's warnings, write JSON lines.

    Other libraries are heard from ``WARNING`` on, whatever they set their own loggers to.
    """
    handler = logging.StreamHandler(stream or sys.stderr)
    handler.setFormatter(JsonLines())
    handler.addFilter(_is_worth_a_line)
    logging.basicConfig(handlers=[handler], level=logging.WARNING, force=True)
    logging.getLogger(OURS).setLevel(logging.INFO)
    logging.captureWarnings(True)


def _is_worth_a_line(record: logging.LogRecord) -> bool:
    return record.levelno >= logging.WARNING or record.name.partition(".")[0] == OURS
