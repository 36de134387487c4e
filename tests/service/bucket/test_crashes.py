"""A service whose files are in a bucket of a store that speaks S3: nothing is lost, doubled, or sent damaged."""

import hashlib
import shutil
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from signal import SIGKILL

import httpx
import pytest

from service.client.connection import ServiceError
from service.files.artifacts import Artifacts
from service.records.jobs import State
from service.settings import Settings
from tests.claims.marked import Compared
from tests.claims.rows import Row, at_least, equal
from tests.service.bucket.object_store import URL, ObjectStore, object_store
from tests.service.support import inspection
from tests.service.support.crash_test import CrashTest, Work, crash_test, undisturbed
from tests.service.support.fakes import wait_until
from tests.service.support.processes import free_port

WORK = Work(speeds=2, sweeps=1, thicknesses=1, run_seconds=0.2)
LONG = replace(WORK, run_seconds=3.0)  # some run is under way when the store stops
# A service that goes round the bucket in seconds, where nothing is too young to go.
BRISK = {"WHIPPLE_RECONCILE_SECONDS": "0.02", "WHIPPLE_POLL_SECONDS": "0.02", "WHIPPLE_RETIRE_SECONDS": "0.01"}
LINKS = {"WHIPPLE_ARTIFACTS_LINKS": "60"}
PATIENCE = 120.0  # s
WAITS = "a result cannot be registered now: the bucket"
# In the order in which one sweep meets them: its runs, then its publication.
LIVES = (
    "object-before-upload",
    "object-after-upload",
    "result-before-registration",
    "result-before-commit",
    "result-after-commit",
    "publication-before-registration",
    "publication-before-commit",
    "object-before-upload",
    "object-after-upload",
    "publication-after-commit",
)


@pytest.fixture
def objects() -> Iterator[ObjectStore]:
    with object_store() as store:
        yield store


@pytest.mark.claim("doors", "bucket-serves", minutes=0.3)
def test_bucket__serves_all_where_the_disk_has_lost_it(
    objects: ObjectStore, tmp_path: Path, compared: Compared
) -> None:
    """A sweep whose files are in a bucket is served after those on the disk are deleted: by links, itself, as a ZIP."""
    with crash_test(WORK, tmp_path, settings=LINKS) as here:
        ids = here.submit()
        here.wait_for_the_end(ids)
        named = {file.path for file in inspection.files(here.store)}
        odd = (named | {"whipple.id"}) ^ set(objects.bucket.names(""))
        compared(equal(f"files and objects that differ, of {len(named)}", expected=set(), got=odd))
        _empty(here)
        compared(*inspection.rows_of_cubes(undisturbed(WORK), here.fetch(ids, tmp_path / "linked")))
        shown = {"report.html", "appendix.html", "report.json"}  # not by links, for a browser shows them
        got = {file.name for file in (here.service.data / "sweeps").rglob("*") if file.is_file()}
        compared(equal("files on the disk after downloads by links", expected=shown, got=got))
        here.service.leave()
        for left in here.service.data.glob("whipple.[!d]*"):  # the id; a database stays
            left.unlink()
        here.service.start(WHIPPLE_ARTIFACTS_LINKS="0")
        here.service.wait_until_ready()
        compared(*inspection.rows_of_cubes(undisturbed(WORK), here.fetch(ids, tmp_path / "sent")))
        _empty(here)
        with here.service.client() as client:
            archive = client.sweep(ids[0]).fetch_archive(tmp_path / "all.zip")
        compared(equal("an archive is there", expected=True, got=archive.is_file()))
        _empty(here)
        [document] = here.work.documents()
        ids.append(here.service.submit({**document, "title": "from the results in the bucket"}))
        here.wait_for_the_end(ids)
        begun = {run.attempt for run in inspection.runs(here.store, ids).values()}
        compared(equal("attempts at each run, also for a second report", expected={1}, got=begun))
        compared(here.row_of_processes())


@pytest.mark.claim("doors", "bucket-directories", minutes=0.3)
def test_services__with_a_directory_each_share_a_bucket(
    objects: ObjectStore, tmp_path: Path, postgresql_url: str, compared: Compared
) -> None:
    """Two services with a directory each share a bucket: each sends all files, and goes on when the other is killed."""
    with crash_test(WORK, tmp_path, database_url=postgresql_url) as here:
        first, second = here.service, replace(here.service, data=tmp_path / "another", name="another", port=free_port())
        here.services.append(second)
        second.start()
        ids = here.submit()
        here.wait_for_the_end(ids)
        second.wait_until_ready()
        with second.client() as client:
            cube = client.sweep(ids[0]).fetch(tmp_path / "from-the-other") / "cube.nc"
        compared(*inspection.rows_of_cubes(undisturbed(WORK), [cube]))
        first.kill()
        more = replace(WORK, thicknesses=2)  # twice as many runs: those of before, and as many new ones
        [document] = more.documents()
        ids = [second.submit(document)]
        here.wait_for_the_end(ids)
        compared(*inspection.rows_of_cubes(undisturbed(more), here.fetch(ids, tmp_path / "more")))
        once = inspection.registered_once(here.store, ids)
        compared(equal("runs with one result, of both", expected=more.runs, got=len(once)))
        compared(equal("exit status", expected=0, got=second.leave()))


@pytest.mark.claim("doors", "bucket-kills", minutes=1.0)
def test_service__that_dies_around_an_upload_leaves_no_orphan(
    objects: ObjectStore, tmp_path: Path, compared: Compared
) -> None:
    """A service that is killed at each point around upload and commit loses, doubles and leaves behind nothing."""
    with crash_test(WORK, tmp_path, settings=BRISK) as here:
        ids = here.submit()
        here.service.kill()
        left = set[str]()
        for point in LIVES:
            here.service.start(fault=point)
            compared(equal(f"exit status at {point}", expected=-SIGKILL, got=here.service.die()))
            compared(equal(f"died at {point}: wrong in store and files", expected=[], got=_wrong(here)))
            left |= _orphans(here, objects)
        compared(at_least("objects that kills have left", limit=1, got=len(left)))
        here.service.start()
        compared(*here.rows_of_results(ids, tmp_path / "cubes"))
        compared(equal("wrong in the end", expected=[], got=_wrong(here)))
        with suppress(AssertionError):
            wait_until(lambda: not _orphans(here, objects), seconds=PATIENCE)
        compared(equal("objects that no row names", expected=set(), got=_orphans(here, objects)))
        compared(here.row_of_processes())


@pytest.mark.claim("doors", "bucket-away", minutes=0.5)
def test_bucket__that_is_away_for_a_while_loses_nothing(
    objects: ObjectStore, tmp_path: Path, compared: Compared
) -> None:
    """While the store of a bucket is stopped nothing accepted is lost, nothing begins, and all resumes by itself."""
    with crash_test(LONG, tmp_path, settings={"WHIPPLE_WORKERS": "1"}) as here:
        ids = here.submit()
        here.wait_until_computing()
        objects.tell("stop")
        why = wait_until(lambda: here.store.queue.status().blocked_reason, seconds=PATIENCE)
        compared(Row("why nothing begins", URL, why, f"the bucket {URL} cannot be used" in why))
        compared(equal("readiness meanwhile: status", expected=503, got=here.service.get("/readyz")))
        blocked = "whipple_queue_blocked 1.0" in httpx.get(f"{here.service.url}/metrics").text
        compared(equal("the metric says so", expected=True, got=blocked))
        [other] = replace(here.work, resolution=5).documents()
        ids.append(here.service.submit(other))
        wait_until(lambda: WAITS in here.service.log.read_text(), seconds=PATIENCE)
        compared(equal("results registered meanwhile", expected=[], got=inspection.files(here.store)))
        objects.tell("start")
        here.wait_for_the_end(ids)
        runs = inspection.runs(here.store, ids).values()
        got = {(run.state, run.attempt) for run in runs}
        compared(equal("runs and their attempts", expected={(State.SUCCEEDED, 1)}, got=got))
        once = len(inspection.registered_once(here.store, ids))
        compared(equal("runs with one result", expected=2 * WORK.runs, got=once))
        compared(equal("wrong in store, files and bucket", expected=[], got=_wrong(here)))
        compared(here.row_of_processes())


@pytest.mark.claim("doors", "bucket-link", minutes=0.2)
def test_link__leads_to_the_bucket_and_is_checked(objects: ObjectStore, tmp_path: Path, compared: Compared) -> None:
    """A download is redirected to a signed link that works for whoever has it; the client refuses a damaged object."""
    with crash_test(WORK, tmp_path, settings=LINKS) as here:
        ids = here.submit()
        here.wait_for_the_end(ids)
        response = httpx.get(f"{here.service.url}/v1/sweeps/{ids[0]}/cube.nc")
        compared(equal("status", expected=307, got=response.status_code))
        link = response.headers["Location"]
        [cube] = [file for file in inspection.files(here.store) if file.name == "cube.nc"]
        address = link.split("?")[0]
        compared(equal("where it leads", expected=True, got=address.endswith(f"/results/whipple/{cube.path}")))
        compared(
            equal(
                "digest of what is there", expected=cube.sha256, got=hashlib.sha256(httpx.get(link).content).hexdigest()
            )
        )
        unsigned = httpx.get(address).status_code
        compared(Row("status without the signature", "no success", unsigned, unsigned >= 400))
        objects.flip(cube.path)
        with here.service.client() as client, pytest.raises(ServiceError, match="Damaged download"):
            client.sweep(ids[0]).fetch(tmp_path / "damaged")
        written = (tmp_path / "damaged" / "cube.nc").exists()
        compared(equal("damaged files that were written", expected=False, got=written))
        compared(here.row_of_processes())


def _empty(here: CrashTest) -> None:
    """Delete every file of runs and sweeps on the disk."""
    for folder in ("runs", "sweeps"):
        shutil.rmtree(here.service.data / folder, ignore_errors=True)


def _wrong(here: CrashTest) -> list[str]:
    """Faults of the store, and each registered file whose copy or object is missing or damaged."""
    artifacts = Artifacts.of(Settings(data=here.service.data))
    named = inspection.files(here.store)
    wrong = [*inspection.contradictions(here.store), *inspection.damaged(here.store, here.artifacts)]
    return [*wrong, *(file.path for file in named if not artifacts.is_in_bucket(file))]


def _orphans(here: CrashTest, objects: ObjectStore) -> set[str]:
    return set(objects.bucket.names("")) - {file.path for file in inspection.files(here.store)} - {"whipple.id"}
