"""Checkpoints of a run: the solver's, with what was read so far in it and the film so far beside it."""

import json
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from solver.checkpoint import Checkpointing

if TYPE_CHECKING:
    from studies.execution import Observer


FILM = ".film.npz"  # in place of the suffix of the checkpoint


def _never() -> bool:
    return False


def _nobody(_: int) -> None:
    """A listener that does not listen."""


class Checkpoints:
    """Writes and reads the observer's part, and says at which step a checkpoint lies on the disk."""

    def __init__(
        self,
        path: Path,
        observer: "Observer",
        *,
        leave: Callable[[], bool] | None,
        saved: Callable[[int], object] | None,
        explain: Callable[[str], object],
    ):
        self._path = path
        self._observer = observer
        self._leave = leave or _never
        self._saved = saved or _nobody
        self._explain = explain
        self._seen = self._mark()

    def of_solver(self) -> Checkpointing:
        """The same as the solver takes it."""
        return Checkpointing(
            path=self._path,
            caller=self._observer.definitions(),
            remember=self._remember,
            recall=self._recall,
            leave=self._look_and_leave,
            tell=self._explain,
        )

    def look(self) -> None:
        """Say that there is another checkpoint than before, if there is."""
        mark = self._mark()
        if mark != self._seen:
            self._seen = mark
            self._say()

    def _look_and_leave(self) -> bool:
        """Called after each step."""
        self.look()
        return self._leave()

    def _remember(self) -> str:
        film = self._observer.film
        if film:
            with suppress(OSError):  # no space: the film will begin where the run goes on
                film.save(self._path.with_suffix(FILM))
        frames = len(film.times) if film else 0
        return json.dumps({"observer": self._observer.remember(), "frames": frames})

    def _recall(self, text: str) -> None:
        remembered = json.loads(text)
        self._observer.recall(remembered["observer"])
        if self._observer.film:
            self._observer.film.resume(self._path.with_suffix(FILM), remembered["frames"])
        self._say()

    def _say(self) -> None:
        """Tell the step: the file begins with a line of JSON."""
        with self._path.open("rb") as file:
            self._saved(json.loads(file.readline())["numbers"]["step"])

    def _mark(self) -> tuple[int, int] | None:
        """What changes when another file takes its place."""
        try:
            found = self._path.stat()
        except OSError:
            return None
        return found.st_ino, found.st_mtime_ns
