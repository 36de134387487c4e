"""What a user gave is refused: every finding names the field, the value, the limit and the cure."""

from collections.abc import Iterable
from dataclasses import asdict, dataclass

from solver.errors import WhippleError


@dataclass(frozen=True)
class Finding:
    """One thing wrong with an input."""

    field: str  # dotted path into the document: "axes.speed[2]"
    value: str  # what was given, as text, shortened
    limit: str  # what is allowed: "a speed between 100 m/s and 20 km/s"
    cure: str  # what to do: "write '6 km/s'"

    def __str__(self) -> str:
        return f"{self.field}: {self.value} is refused; allowed: {self.limit}; {self.cure}"


class InvalidInput(WhippleError):
    """An input is refused; ``findings`` has all that was found, not only the first."""

    def __init__(self, findings: Iterable[Finding]):
        self.findings = tuple(findings)
        super().__init__("\n".join(str(finding) for finding in self.findings))

    def as_json(self) -> list[dict[str, str]]:
        """Findings as plain objects, for a problem document."""
        return [asdict(finding) for finding in self.findings]
