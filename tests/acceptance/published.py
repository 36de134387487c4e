"""Runs that cost nothing, and the real publication of them: stands in for ``studies.run`` and ``studies.publish``."""

from studies.publish import publish
from tests.service.targets import Run, execute

__all__ = ["Run", "execute", "publish"]
