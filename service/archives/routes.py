"""The address of a ZIP file with all files of a sweep, never whole in memory."""

import hashlib
import json
from collections.abc import Iterator, Mapping

from fastapi import APIRouter, Request, Response
from fastapi.responses import StreamingResponse
from zipstream import ZipStream

from service.api.dependencies import AppArtifacts, AppStore, SweepId
from service.api.downloads import media_type_of, serves
from service.api.errors import FileDamaged, NotReady
from service.api.routes import Routes
from service.api.routes.files import plain, progress_of
from service.api.turns import WaitingThreads, in_waiting_thread, turn_of
from service.files.artifacts import Artifacts
from service.records.jobs import Stored
from studies.quantities.files import ARCHIVE, DIGESTS

PIECE = 1 << 20  # bytes of a file that are read at once

router = APIRouter(prefix="/v1/sweeps/{id}", tags=["results"])
ROUTES = Routes("archives", 21, guarded=(router,))


@serves(
    router,
    f"/{ARCHIVE}",
    (ARCHIVE,),
    "Everything of a sweep that has ended in one file: its document, what it published, and the stored files of its "
    "runs in `runs/ID/`; `SHA256SUMS` has the digest of each (`sha256sum --check SHA256SUMS`)",
)
async def get_archive_zip(id: SweepId, request: Request, store: AppStore, artifacts: AppArtifacts) -> Response:
    threads: WaitingThreads = request.app.state.waiting_threads

    def archived() -> tuple[str, ZipStream]:
        sweep = store.sweeps.get(id)
        if not sweep.is_terminal:
            raise NotReady(f"the sweep is {progress_of(sweep)}")
        document = json.dumps(store.sweeps.document(id), ensure_ascii=False, indent=1).encode()
        return sweep.name, _archive_of(artifacts, store.publications.archived(id), {"sweep.json": document})

    name, archive = await in_waiting_thread(request, archived)
    filename = f"{plain(name)}-{ARCHIVE}"
    return StreamingResponse(
        threads.each(turn_of(request).caller, iter(archive)),
        media_type=media_type_of(ARCHIVE),
        headers={"Content-Length": str(len(archive)), "Content-Disposition": f'attachment; filename="{filename}"'},
    )


def _archive_of(artifacts: Artifacts, files: Mapping[str, Stored], texts: Mapping[str, bytes]) -> ZipStream:
    """A ZIP file of stored files and texts by name: a piece of a file is in memory at a time.

    The files are stored as they are, most of them are compressed already, so that the length of the whole is known
    before. One of them has the digests of the others, as ``sha256sum --check`` reads them.

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
        while piece := file.read(PIECE):
            sha256.update(piece)
            yield piece
    if sha256.hexdigest() != stored.sha256:
        raise FileDamaged(f"{stored.name} is not the file that was registered")
