"""Runs of ``targets``, of which cube and report are the real ones, without figures."""

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tests.service.support.targets import Run, execute

__all__ = ["Run", "execute", "publish"]


def publish(
    document: Mapping[str, Any],
    outcomes: Mapping[str, Mapping[str, Any]],
    directory: Path,
    sections: Mapping[str, Path] | None = None,
) -> dict[str, str]:
    (directory / "pid").write_text(str(os.getpid()))
    # Most processes of a crash test compute runs alone, and need not load these.
    from studies.reports import publish as real
    from tests.studies.support.printed import undrawn

    with undrawn():
        return real.publish(document, outcomes, directory, sections)
