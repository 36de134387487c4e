"""Runs that cost nothing, really published: for ``studies.runs.execution`` and ``studies.reports.publish``."""

from studies.reports.publish import publish
from tests.service.support.targets import Run, execute

__all__ = ["Run", "execute", "publish"]
