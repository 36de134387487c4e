"""Errors of user input: every error names the field, the value, the limit and the cure."""

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import islice

from solver.errors import WhippleError

MOST_FINDINGS = 200  # of one input, where its reading stops; with its cure one takes up to a millisecond (2026-11)


@dataclass(frozen=True)
class Finding:
    """One error in an input."""

    field: str  # dotted path into the document: "axes.speed[2]"
    value: str  # what was given, as text, shortened
    limit: str  # what is allowed: "a speed between 100 m/s and 20 km/s"
    cure: str  # what to do: "write '6 km/s'"

    def __str__(self) -> str:
        return f"{self.field}: {self.value} is refused; allowed: {self.limit}; {self.cure}"


class InvalidInput(WhippleError):
    """An input is refused; ``findings`` lists its errors, up to ``MOST_FINDINGS``.

    ``more`` is the number of errors that a response has left out.
    """

    def __init__(self, findings: Iterable[Finding], *, more: int = 0):
        self.findings = tuple(islice(findings, MOST_FINDINGS))
        self.more = more
        super().__init__("\n".join(str(finding) for finding in self.findings))


class Findings(list[Finding]):
    """The errors so far; with ``MOST_FINDINGS`` errors it raises InvalidInput, which ends the reading."""

    def append(self, finding: Finding) -> None:
        super().append(finding)
        if len(self) >= MOST_FINDINGS:
            raise InvalidInput(self)

    def extend(self, findings: Iterable[Finding]) -> None:
        for finding in findings:
            self.append(finding)


class MissingExtra(WhippleError):
    """Libraries that are not part of a plain installation are needed."""
