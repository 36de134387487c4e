"""Notes of features on outcomes: beside that of a run, and below those of a sweep.

A feature offers one through the entry-point group ``whipple.service.pages.notes``.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from solver.registry import entries
from studies.quantities.parameters import Plain, Value


@dataclass(frozen=True)
class OutcomeNote:
    """What pages say of a measured outcome, rendered; empty where there is nothing to say."""

    name: str  # of the outcome
    of_run: Callable[[float, Mapping[str, Value]], str]  # by its value and the parameters of the run
    of_sweep: Callable[[Mapping[str, Plain]], str]  # by the canonical document


def note_on(outcome: str) -> OutcomeNote | None:
    """The note on a measurement; None of one without any."""
    note: OutcomeNote | None = entries(__name__, "NOTE").get(outcome)
    return note
