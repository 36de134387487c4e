"""Interruptible runs: checkpoints are written during the run, and a simulation is restored from the last one."""

from dataclasses import asdict, dataclass, field
from time import monotonic
from typing import Protocol

from solver.audit import Audit
from solver.checkpoint import Carried, Checkpointing, CheckpointRefused, fingerprint, read_checkpoint, write_checkpoint
from solver.errors import Interrupted
from solver.problem import Problem


class Stepping(Protocol):
    """The state that a checkpoint stores and restores: a ``simulation.Simulation``."""

    problem: Problem
    shares: int
    time: float
    step: int

    def carried(self) -> Carried:
        """The state that passes from this step to the next."""

    def take_over(self, carried: Carried) -> None:
        """Continue from the state of a simulation of the same problem."""


@dataclass
class Observing:
    """The state of an observed run besides its simulation."""

    history: list[Audit] = field(default_factory=list)
    due: float = 0.0  # time of the next observation, s


class CheckpointWriter:
    """Writes the checkpoints of a run, and restores it from the last one."""

    def __init__(self, simulation: Stepping, observing: Observing, checkpoint: Checkpointing, interval: float):
        self.simulation = simulation
        self.observing = observing
        self.checkpoint = checkpoint
        self.mark = fingerprint(
            simulation.problem, interval=repr(interval), caller=checkpoint.caller, shares=str(simulation.shares)
        )
        self.written = monotonic()

    def restore(self) -> None:
        """Continue from the checkpoint file, or report the reason why it cannot be used."""
        try:
            carried = read_checkpoint(self.checkpoint.path, self.mark)
        except FileNotFoundError:
            return
        except (CheckpointRefused, OSError) as error:
            self.checkpoint.log(f"from the start, without the checkpoint: {error}")
            return
        observing = carried.numbers["observing"]
        self.checkpoint.restore_observer(observing["observer"])
        self.observing.history = [Audit.from_plain(audit) for audit in observing["history"]]
        self.observing.due = observing["due"]
        self.simulation.take_over(carried)
        self.checkpoint.on_checkpoint(self.simulation.step)
        self.checkpoint.log(f"from the checkpoint at t = {self.simulation.time:.6g} s, step {self.simulation.step}")

    def after_step(self) -> None:
        """Write a checkpoint when one is due; raise Interrupted when the caller asks the run to stop."""
        must_stop = self.checkpoint.must_stop()
        if must_stop or monotonic() - self.written >= self.checkpoint.seconds_between:
            self._write()
        if must_stop:
            raise Interrupted(time=self.simulation.time, step=self.simulation.step)

    def _write(self) -> None:
        carried = self.simulation.carried()
        observing = {
            "history": [asdict(audit) for audit in self.observing.history],
            "due": self.observing.due,
            "observer": self.checkpoint.observer_state(),
        }
        carried = Carried({**carried.numbers, "observing": observing}, carried.arrays)
        try:
            write_checkpoint(self.checkpoint.path, self.mark, carried)
        except OSError as error:
            self.checkpoint.log(f"a checkpoint could not be written: {error}")
        else:
            self.checkpoint.on_checkpoint(self.simulation.step)
        self.written = monotonic()
