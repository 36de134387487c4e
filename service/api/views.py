"""What pages show of the inside of a run, made from its files: its film, its matter in space, its radiograph.

Each is one file of ``studies.films.packed``, of at most ``MOST_BYTES`` before compression, sent as it is cached.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from service.api.errors import Busy, ViewFailed
from service.api.made_files import MadeFiles, run_child
from service.files.artifacts import Artifacts, digest
from service.records.jobs import Stored
from studies.quantities.files import FILM, SECTIONS, STATE

# The files of a run from which each view is made; any one of them will do, the first one best.
SOURCES: Mapping[str, tuple[str, ...]] = {"film": (FILM, SECTIONS), "cloud": (STATE,), "radiograph": (SECTIONS,)}


class Views(MadeFiles):
    """The cache of views; a page asks for one after the other, and waits while another page's is made."""

    module, noun, suffix, failure, wait = "service.api.views", "picture", ".gz", ViewFailed, 20.0
    _waiting = 0
    MOST_WAITING = 4  # requests, each of which holds a thread

    def file(self, view: str, run: Mapping[str, Any], source: Stored, artifacts: Artifacts) -> tuple[Path, str]:
        """A view of a run (as JSON) from one of its files, and its SHA-256; raises Busy, ViewFailed."""
        if self._waiting >= self.MOST_WAITING:
            raise Busy("other pictures are being made")
        self._waiting += 1
        try:
            path = str(artifacts.path(source))
            return self.made_from({"view": view, "run": run, "path": path, "sha256": source.sha256})
        finally:
            self._waiting -= 1


# --- in the child process -------------------------------------------------------------------------


def make(inputs: dict[str, Any], file: Path) -> None:
    """Make a view; ValueError where the source is damaged."""
    from studies.films.packed import write
    from studies.runs import views
    from studies.runs.run import Run

    source = Path(inputs["path"])
    if digest(source) != inputs["sha256"]:
        raise ValueError(f"{source.name} is not the file that was registered")
    write(getattr(views, inputs["view"])(Run.from_json(inputs["run"]), source), file)


if __name__ == "__main__":
    run_child(make)
