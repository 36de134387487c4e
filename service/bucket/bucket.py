"""A bucket: registered files as objects of S3, of a store compatible with it, or of any other that fsspec opens.

An object is named as its file is in the data directory. It is written whole or not at all, before a row names it, and
never changes; queue, leases and terms stay in the database. Credentials and the address of the store are those of its
library (``AWS_ACCESS_KEY_ID``, ``AWS_ENDPOINT_URL``, ...).
"""

import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING

from service.files.stores import IDENTITY, Bucket, FilesAway
from studies.quantities.findings import Finding, InvalidInput

if TYPE_CHECKING:
    from fsspec import AbstractFileSystem
    from pydantic import JsonValue

PROBE = ".doctor"
PAUSE_SECONDS = 60.0  # after an error nothing is begun for so long, unless a later use succeeds
BLOCK = 4 << 20  # bytes that are asked for at once
AGAIN_SECONDS = 10.0  # pause of downloads after an error, so that only the first ones wait for a store that hangs
# A store that hangs is away after so long; links are signed as every S3 takes them.
CONNECTION: "dict[str, JsonValue]" = {
    "connect_timeout": 5,
    "read_timeout": 10,
    "retries": {"max_attempts": 0},
    "signature_version": "s3v4",
}
# Of one kind of store. By default s3fs holds ten parts of 50 MB of a file that it uploads (547 MB, 2026-11).
OPTIONS: "Mapping[str, Mapping[str, JsonValue]]" = {
    "file": {"auto_mkdir": True},
    "s3": {"max_concurrency": 1, "config_kwargs": CONNECTION},
}
EXTRA = "pip install 'whipple[s3]'; other stores need the package that fsspec names"


class ObjectBucket(Bucket):
    """``stores.Bucket`` of the objects below a URL, with the prefix that it names."""

    def __init__(self, url: str):
        try:
            import fsspec

            own = OPTIONS.get(url.partition(":")[0], {})
            opened = fsspec.core.url_to_fs(url, use_listings_cache=False, skip_instance_cache=True, **own)
        except (ImportError, ValueError) as error:
            cure = f"correct the URL, or {EXTRA}"
            raise InvalidInput([Finding("artifacts", url, f"a URL that fsspec opens: {error}", cure)]) from None
        self.url = url
        self.files: AbstractFileSystem = opened[0]
        self.files.retries = 1  # s3fs would try five times, each for as long
        self._root = str(opened[1]).rstrip("/")
        self._failure: tuple[float, str] | None = None  # monotonic, and what a use met
        self._must_upload = False  # until it is over: it was an upload

    def blocked_reason(self) -> str | None:
        failure = self._failure
        return failure[1] if failure is not None and time.monotonic() - failure[0] < PAUSE_SECONDS else None

    def put(self, file: Path, name: str) -> None:
        with self._used(uploads=True):
            self.files.put_file(str(file), self._path(name))

    def get(self, name: str, file: Path) -> None:
        if self._failure is not None and time.monotonic() - self._failure[0] < AGAIN_SECONDS:
            raise FilesAway(self._failure[1])
        with self._used():
            self.files.get_file(self._path(name), str(file))

    def chunks(self, name: str) -> Iterator[bytes]:
        with self._used(), self.files.open(self._path(name), "rb", block_size=BLOCK) as stream:
            while piece := stream.read(BLOCK):
                yield piece

    def size(self, name: str) -> int | None:
        try:
            with self._used():
                return int(self.files.info(self._path(name))["size"])
        except FileNotFoundError:
            return None

    def names(self, folder: str) -> list[str]:
        with self._used():
            found = self.files.find(self._path(folder))
        return sorted(path[len(self._root) + 1 :] for path in found)

    def age(self, name: str) -> float:
        with self._used():
            written: datetime = self.files.modified(self._path(name))
        return time.time() - written.timestamp()

    def remove(self, name: str) -> None:
        with self._used():
            self.files.rm_file(self._path(name))

    def link(self, name: str, seconds: int) -> str | None:
        try:
            with self._used():
                return str(self.files.sign(self._path(name), expiration=seconds))
        except NotImplementedError:
            return None

    def identity(self) -> str | None:
        with self._used():
            if not self.files.exists(self._path(IDENTITY)):
                self.files.find(self._path(IDENTITY))  # an error where there is no such bucket
                return None
            return bytes(self.files.cat_file(self._path(IDENTITY))).decode().strip()

    def identify(self, id: str) -> None:
        with self._used():
            self.files.pipe_file(self._path(IDENTITY), id.encode())

    def probe(self) -> bool:
        with self._used():
            self.files.pipe_file(self._path(PROBE), b"ready?")
            self.files.cat_file(self._path(PROBE))
            self.files.rm_file(self._path(PROBE))
            is_versioned = getattr(self.files, "is_bucket_versioned", None)
            return is_versioned is not None and bool(is_versioned(self._root.partition("/")[0]))

    def _path(self, name: str) -> str:
        return f"{self._root}/{name}"

    @contextmanager
    def _used(self, *, uploads: bool = False) -> Iterator[None]:
        """Note how a use ends: each library has errors of its own, and a missing bucket is not a missing object."""
        try:
            yield
        except NotImplementedError:
            raise
        except Exception as error:
            if isinstance(error, FileNotFoundError) and self._is_there():
                raise
            reason = f"the bucket {self.url} cannot be used ({error}); see `whipple doctor`"
            self._failure = time.monotonic(), reason
            self._must_upload |= uploads
            raise FilesAway(reason) from error
        if uploads or not self._must_upload:
            self._failure, self._must_upload = None, False

    def _is_there(self) -> bool:
        """Whether the bucket itself can be read."""
        with suppress(Exception):
            return bool(self.files.exists(self._path(IDENTITY)))
        return False
