"""A run that can be left and gone on with: it writes its checkpoints, and takes a simulation back to the last one."""

from dataclasses import asdict, dataclass, field
from time import monotonic
from typing import Protocol

from solver.audit import Audit
from solver.checkpoint import (
    Carried,
    Checkpointing,
    Refused,
    fingerprint,
    read_checkpoint,
    write_checkpoint,
)
from solver.errors import Interrupted
from solver.problem import Problem


class Stepping(Protocol):
    """What is written to a checkpoint and taken back: a ``simulation.Simulation``."""

    problem: Problem
    shares: int
    time: float
    step: int

    def carried(self) -> Carried:
        """What goes from this step to the next."""

    def take_over(self, carried: Carried) -> None:
        """Go on from what a simulation of the same problem carried."""


@dataclass
class Observing:
    """What an observed run keeps besides its simulation."""

    history: list[Audit] = field(default_factory=list)
    due: float = 0.0  # time of the next observation, s


class Keeper:
    """Writes the checkpoints of a run, and takes it back to the last one."""

    def __init__(
        self, simulation: Stepping, observing: Observing, checkpoint: Checkpointing, interval: float
    ):
        self.simulation = simulation
        self.observing = observing
        self.checkpoint = checkpoint
        self.mark = fingerprint(
            simulation.problem,
            interval=repr(interval),
            caller=checkpoint.caller,
            shares=str(simulation.shares),
        )
        self.written = monotonic()

    def restore(self) -> None:
        """Go on from the file, or say why not."""
        try:
            carried = read_checkpoint(self.checkpoint.path, self.mark)
        except FileNotFoundError:
            return
        except (Refused, OSError) as error:
            self.checkpoint.tell(f"from the start, without the checkpoint: {error}")
            return
        observing = carried.numbers["observing"]
        self.checkpoint.recall(observing["remembered"])
        self.observing.history = [Audit(**audit) for audit in observing["history"]]
        self.observing.due = observing["due"]
        self.simulation.take_over(carried)
        self.checkpoint.saved(self.simulation.step)
        self.checkpoint.tell(
            f"from the checkpoint at t = {self.simulation.time:.6g} s, step {self.simulation.step}"
        )

    def after_step(self) -> None:
        """Write when it is time; leave when asked to, by Interrupted."""
        leave = self.checkpoint.leave()
        if leave or monotonic() - self.written >= self.checkpoint.seconds_between:
            self._write()
        if leave:
            raise Interrupted(time=self.simulation.time, step=self.simulation.step)

    def _write(self) -> None:
        carried = self.simulation.carried()
        observing = {
            "history": [asdict(audit) for audit in self.observing.history],
            "due": self.observing.due,
            "remembered": self.checkpoint.remember(),
        }
        carried = Carried({**carried.numbers, "observing": observing}, carried.arrays)
        try:
            write_checkpoint(self.checkpoint.path, self.mark, carried)
        except OSError as error:
            self.checkpoint.tell(f"a checkpoint could not be written: {error}")
        else:
            self.checkpoint.saved(self.simulation.step)
        self.written = monotonic()
