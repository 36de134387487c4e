"""Where registered files are kept beyond the data directory: a bucket, by the scheme of its URL.

To add a kind: a class like ``Bucket``, made from the URL, and a line ``scheme = "module:Class"`` of the
entry-point group ``whipple.service.files.stores``.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Protocol

from solver.errors import WhippleError
from solver.registry import points

STORES = "service.files.stores"  # the group of entry points
IDENTITY = "whipple.id"  # object, and file of the data directory, with the id of the database


class FilesAway(WhippleError, OSError):
    """The bucket cannot be used now; nothing was changed, and a later try may succeed."""


class Bucket(Protocol):
    """Files by name, each written whole or not at all, and never changed; all methods but the first raise FilesAway."""

    url: str

    def blocked_reason(self) -> str | None:
        """The reason why nothing may be begun; None: the last use succeeded, or failed long ago."""

    def put(self, file: Path, name: str) -> None:
        """Write an object from a file."""

    def get(self, name: str, file: Path) -> None:
        """Write an object to a file; raises FileNotFoundError."""

    def chunks(self, name: str) -> Iterator[bytes]:
        """The bytes of an object in pieces; raises FileNotFoundError."""

    def size(self, name: str) -> int | None:
        """Bytes of an object; None: there is none."""

    def names(self, folder: str) -> list[str]:
        """The objects below a folder."""

    def age(self, name: str) -> float:
        """Seconds since an object was written; raises FileNotFoundError."""

    def remove(self, name: str) -> None:
        """Remove an object."""

    def link(self, name: str, seconds: int) -> str | None:
        """A signed link that is valid for so many seconds; None: this kind of store has none."""

    def identity(self) -> str | None:
        """The id of the database whose files it has; None: it is empty."""

    def identify(self, id: str) -> None:
        """Let it belong to a database."""

    def probe(self) -> bool:
        """Write, read and remove an object; whether the bucket keeps removed ones as versions."""


def bucket_at(url: str) -> Bucket:
    """The bucket of a URL, whose scheme the settings have checked; raises InvalidInput where it cannot be opened."""
    [point] = points(STORES).select(name=url.partition("://")[0])
    bucket: Bucket = point.load()(url)
    return bucket
