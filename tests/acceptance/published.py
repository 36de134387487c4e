"""Runs that cost nothing, really published: stands in for ``studies.execution`` and ``studies.publish``."""

from studies.publish import publish
from tests.service.targets import Run, execute

__all__ = ["Run", "execute", "publish"]
