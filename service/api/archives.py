"""All files of a sweep as one ZIP file, streamed: a piece of a file is in memory at a time.

The files are stored as they are, most of them are compressed already, so that the length of the whole is known before.
One of them has the digests of the others, as ``sha256sum --check`` reads them.
"""

import hashlib
from collections.abc import Iterator, Mapping

from zipstream import ZipStream

from service.api.errors import FileDamaged
from service.files.artifacts import Artifacts
from service.records.jobs import Stored
from studies.quantities.files import DIGESTS

_PIECE = 1 << 20  # bytes


def archive_of(artifacts: Artifacts, files: Mapping[str, Stored], texts: Mapping[str, bytes]) -> ZipStream:
    """A ZIP file of stored files and texts by name; its length is ``len``, iterating gives its bytes.

    Raises FileDamaged: before the first byte for a file that is missing or has another size, at its end for one with
    another digest, so that no damaged file is ever part of a whole archive.
    """
    lacking = [
        name for name, stored in files.items() if not (artifacts.is_there(stored) or artifacts.is_in_bucket(stored))
    ]
    if lacking:
        raise FileDamaged(
            f"{len(lacking)} files are lost or damaged, the first is {lacking[0]}; ask again later, or restore them"
        )
    digests = {name: stored.sha256 for name, stored in files.items()}
    digests |= {name: hashlib.sha256(text).hexdigest() for name, text in texts.items()}
    lines = "".join(f"{sha256}  {name}\n" for name, sha256 in sorted(digests.items()))
    archive = ZipStream(sized=True)
    for name, text in {**texts, DIGESTS: lines.encode()}.items():
        archive.add(text, name)
    for name, stored in files.items():
        archive.add(_content(artifacts, stored), name, size=stored.size)
    return archive


def _content(artifacts: Artifacts, stored: Stored) -> Iterator[bytes]:
    sha256 = hashlib.sha256()
    with artifacts.local(stored).open("rb") as file:
        while piece := file.read(_PIECE):
            sha256.update(piece)
            yield piece
    if sha256.hexdigest() != stored.sha256:
        raise FileDamaged(f"{stored.name} is not the file that was registered")
