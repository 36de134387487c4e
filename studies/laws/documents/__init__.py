"""Laws that a sweep brings along under ``laws``, beside those that ship; they change no run.

How to add a kind of them: an entry of the group ``whipple.studies.laws.documents``, a ``LawReader``; no module here.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

from solver.registry import entries
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


@dataclass(frozen=True)
class LawReader:
    """What reads the document of such a law."""

    name: str
    # The law of a document at a path; raises InvalidInput with every finding, each below the path.
    read: Callable[[object, str], OwnLaw]


def read_law(document: object, path: str) -> OwnLaw:
    """The law of a document; raises InvalidInput where nothing here reads one."""
    for reader in entries(__name__, "READER").values():
        law: OwnLaw = reader.read(document, path)
        return law
    raise refusal(path, document, "no laws: nothing that reads them is installed", "leave laws out")
