"""What endpoints are given: the parts of the app, pages, and what a request says."""

import hashlib
import re
from collections.abc import Mapping
from typing import Annotated, Any

from fastapi import Depends, Header, Path, Query, Request
from pydantic import ValidationError
from starlette.requests import ClientDisconnect

from service.api.documents import read_json, read_yaml
from service.api.errors import BodyTooLarge, Malformed, ServiceNotReady, UnsupportedMediaType
from service.api.event_streams import Live
from service.api.keys import Submitter
from service.api.partial_cubes import PartialCubes
from service.api.queue_schemas import Change
from service.files.artifacts import Artifacts
from service.queue import data_identity as identity
from service.records.jobs import PRIORITIES, Keep, Submission
from service.records.settings import Settings
from service.store import Store
from studies.sweeps.sweep import Sweep, SweepLimits
from studies.values.errors import Finding, InvalidInput
from studies.values.nearest import shown

LONGEST_BODY = 4 * 1024 * 1024  # bytes; ten thousand observations take about one million
LONGEST_CHANGE = 128 * 1024  # bytes; a change is one number
READERS = {
    "application/json": read_json,
    "application/yaml": read_yaml,
    "application/x-yaml": read_yaml,
    "text/yaml": read_yaml,
}
IDEMPOTENCY_KEY = re.compile(r"[!-~]{1,200}")  # what can be seen, without spaces


def the_store(request: Request) -> Store:
    """The store that the app was built with."""
    return request.app.state.store


def the_settings(request: Request) -> Settings:
    """The settings that the app was built with."""
    return request.app.state.settings


def check_directory(settings: Settings, store: Store) -> None:
    """Raise ServiceNotReady where the data directory is not the one of the database."""
    try:
        identity.check(settings, store)
    except identity.WrongDirectory as error:
        raise ServiceNotReady(error.what) from None


def the_artifacts(request: Request) -> Artifacts:
    """The files of the service."""
    return Artifacts(request.app.state.settings.data)


def the_partial_cubes(request: Request) -> PartialCubes:
    """The cubes of sweeps that have not ended."""
    return request.app.state.partial_cubes


def the_live(request: Request) -> Live:
    """The open event streams."""
    return request.app.state.live


StoreGiven = Annotated[Store, Depends(the_store)]
SettingsGiven = Annotated[Settings, Depends(the_settings)]
ArtifactsGiven = Annotated[Artifacts, Depends(the_artifacts)]
PartialCubesGiven = Annotated[PartialCubes, Depends(the_partial_cubes)]
LiveGiven = Annotated[Live, Depends(the_live)]

SweepId = Annotated[str, Path(description="what the answer to the submission said")]
RunId = Annotated[str, Path(description="what the list of a sweep's runs says")]
Cursor = Annotated[str | None, Query(description="`next_cursor` of the page before")]
Limit = Annotated[int, Query(ge=1, le=1000, description="items on a page")]


# --- bodies ---------------------------------------------------------------------------------------


async def the_body(request: Request) -> bytes:
    """The body, up to the limit. (The limit of the framework answers in plain text, so it is counted here.)"""
    declared = request.headers.get("content-length", "")
    body = bytearray()
    if declared.isdigit() and int(declared[:18]) > LONGEST_BODY:
        raise BodyTooLarge(f"{declared[:18]} bytes; at most {LONGEST_BODY}")
    try:
        async for chunk in request.stream():
            body += chunk
            if len(body) > LONGEST_BODY:
                raise BodyTooLarge(f"more than {LONGEST_BODY} bytes")
    except ClientDisconnect:
        raise Malformed("the body ended before its length") from None
    return bytes(body)


BodyGiven = Annotated[bytes, Depends(the_body)]


def the_sweep(request: Request, body: BodyGiven, settings: SettingsGiven) -> Sweep:
    """The sweep that the body describes, checked in full; raises InvalidInput with every finding."""
    request.state.document = document = _document(request, body)
    return Sweep.parse(document, SweepLimits(max_runs=settings.max_runs))


SweepGiven = Annotated[Sweep, Depends(the_sweep)]


def the_change(request: Request, body: BodyGiven) -> Change:
    """What shall be changed of a sweep; raises InvalidInput."""
    if _media_type(request) not in ("application/json", "application/merge-patch+json"):
        raise UnsupportedMediaType(f"{_media_type(request)!r}; send application/json")
    if len(body) > LONGEST_CHANGE:
        raise BodyTooLarge(f"{len(body)} bytes; at most {LONGEST_CHANGE} of a change")
    request.state.document = document = read_json(body)
    try:
        return Change.model_validate(document)
    except ValidationError as error:
        raise InvalidInput(_wrong_change(one) for one in error.errors()) from None


def _wrong_change(error: Mapping[str, Any]) -> Finding:
    place = ".".join(map(str, error["loc"])) or "document"
    limit = f"`priority` alone, a whole number from {PRIORITIES[0]} to {PRIORITIES[-1]}"
    return Finding(place, shown(error["input"]), limit, 'send for example {"priority": -10}')


ChangeGiven = Annotated[Change, Depends(the_change)]


def _document(request: Request, body: bytes) -> Any:
    media_type = _media_type(request)
    reader = READERS.get(media_type)
    if reader is None:
        raise UnsupportedMediaType(f"{media_type[:80]!r}; send one of: {', '.join(READERS)}")
    return reader(body)


def _media_type(request: Request) -> str:
    return request.headers.get("content-type", "").partition(";")[0].strip().lower()


# --- submission -----------------------------------------------------------------------------------

Priority = Annotated[
    int,
    Query(
        ge=PRIORITIES[0],
        le=PRIORITIES[-1],
        description="smaller is sooner, before all sweeps of larger numbers",
    ),
]
KeepGiven = Annotated[
    Keep,
    Query(
        description="what is kept of each run: `numbers`, also the `final` state, also the `film`"
    ),
]
IdempotencyKey = Annotated[
    str | None,
    Header(
        description="any text of your own: the same key with the same request is the same sweep, "
        "however often it is sent"
    ),
]


def the_submission(
    request: Request,
    caller: Submitter,
    sweep: SweepGiven,
    body: BodyGiven,
    priority: Priority = 0,
    keep: KeepGiven = Keep.FINAL,
    idempotency_key: IdempotencyKey = None,
) -> Submission:
    """A sweep with what its owner says about it.

    What is said about it stands in the query, not in the document: the document is the question, which
    is hashed, stored in the cube and submitted again by others; how urgent it is to somebody, and what
    is kept beside the answer, is no part of it.
    """
    idempotency = None
    if idempotency_key is not None:
        said = f"{_media_type(request)}\n{priority}\n{keep}\n".encode()
        idempotency = (_plain_key(idempotency_key), hashlib.sha256(said + body).hexdigest())
    return Submission(sweep, caller.name, priority, keep, idempotency)


SubmissionGiven = Annotated[Submission, Depends(the_submission)]


def _plain_key(given: str) -> str:
    """An Idempotency-Key as it counts: a quoted one (as the draft of its standard has it) without quotes."""
    key = given[1:-1] if len(given) > 1 and given[0] == given[-1] == '"' else given
    if not IDEMPOTENCY_KEY.fullmatch(key):
        limit = "1 to 200 letters, digits and signs, without spaces"
        raise InvalidInput(
            [Finding("Idempotency-Key", shown(given), limit, "write for example a UUID")]
        )
    return key
