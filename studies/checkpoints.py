"""Checkpoints of a run: the solver's, with what was read so far in it and the film so far beside it."""

import json
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from solver.checkpoint import Checkpointing

if TYPE_CHECKING:
    from studies.execution import Observer


FILM = ".film.npz"  # in place of the suffix of the checkpoint


class Checkpoints:
    """Writes and reads the observer's part of the checkpoints at a path."""

    def __init__(self, path: Path, observer: "Observer"):
        self._path = path
        self._observer = observer

    def of_solver(self, **listeners: Callable[..., Any] | None) -> Checkpointing:
        """The same as the solver takes it, with its ``leave``, ``saved`` and ``tell`` where they are given."""
        given: Mapping[str, Any] = {
            name: listener for name, listener in listeners.items() if listener is not None
        }
        return Checkpointing(
            path=self._path,
            caller=self._observer.definitions(),
            remember=self._remember,
            recall=self._recall,
            **given,
        )

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
