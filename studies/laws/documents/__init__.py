"""Laws that a sweep brings along, read by the entry points ``whipple.studies.laws.documents``; they change no run."""

from typing import TYPE_CHECKING, Protocol

from solver.registry import points
from studies.quantities.findings import refusal
from studies.quantities.parameters import Plain

if TYPE_CHECKING:
    from studies.laws import Law


class OwnLaw(Protocol):
    """A law of a sweep."""

    @property
    def name(self) -> str: ...
    @property
    def quantity(self) -> str: ...

    def document(self) -> dict[str, Plain]:
        """The law as plain values that its reader reads as itself."""

    def as_law(self) -> "Law":
        """The law as every other one, for cube and report."""


def read_law(document: object, path: str) -> OwnLaw:
    """The law of a document; raises InvalidInput with every finding, each below the path, or as nothing reads it."""
    for point in points(__name__):
        law: OwnLaw = point.load()(document, path)
        return law
    raise refusal(path, document, "no laws: nothing that reads them is installed", "leave laws out")
