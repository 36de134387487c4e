"""What endpoints ask for: parts of the app, request bodies, child processes, submissions, the Link header of pages."""

import hashlib
import re
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import AsyncExitStack, asynccontextmanager, suppress
from dataclasses import replace
from typing import Annotated

from fastapi import Depends, Header, Path, Query, Request, Response, params
from pydantic import ValidationError
from starlette.concurrency import run_in_threadpool

from service.api.access import Caller
from service.api.browsers import body_of
from service.api.documents import pointer, read_json
from service.api.errors import UnsupportedMediaType
from service.api.readers import Readers
from service.api.readiness import ReadinessCheck
from service.api.reading import PARSERS, Given, Made, Posted
from service.api.schemas import SweepChange
from service.api.turns import turn_of
from service.files.artifacts import Artifacts
from service.files.disk_space import free_bytes, shown_size
from service.records.expansion import ExpandedSweep
from service.records.jobs import PRIORITIES, USUAL_PRIORITIES, Keep, Quota, Scope, Submission, SweepStatus, at_least
from service.settings import Settings
from service.store import Store
from studies.quantities.findings import Finding, InvalidInput, shown

LONGEST_BODY = 4 * 1024 * 1024  # bytes; ten thousand observations take about one million
LONGEST_CHANGE = 128 * 1024  # bytes; a change is one number
IDEMPOTENCY_KEY = re.compile(r"[!-~]{1,200}")  # visible ASCII without spaces


AppPart = Store | Settings | Artifacts | ReadinessCheck


def _part(name: str) -> params.Depends:
    """A part of the app as a dependency."""

    async def part(request: Request) -> AppPart:
        return getattr(request.app.state, name)

    return params.Depends(part)


AppStore = Annotated[Store, _part("store")]
AppSettings = Annotated[Settings, _part("settings")]
AppArtifacts = Annotated[Artifacts, _part("artifacts")]
LocalArtifacts = Annotated[Artifacts, _part("local_artifacts")]  # those on the disk: no bucket is asked
AppReadiness = Annotated[ReadinessCheck, _part("readiness")]

SweepId = Annotated[str, Path(description="Sweep id returned by POST /v1/sweeps")]
RunId = Annotated[str, Path(description="Run id from the list of a sweep's runs")]
Cursor = Annotated[str | None, Query(description="`next_cursor` of the previous page")]
Prefix = Annotated[str, Query(pattern="^[0-9a-f]{0,32}$", description="Only ids that begin with these digits")]
PageLimit = Annotated[int, Query(ge=1, le=1000, description="Items per page")]


def link_next(request: Request, response: Response, cursor: str | None) -> None:
    """Name the next page, if there is one, in a Link header (RFC 8288)."""
    if cursor is not None:
        url = request.url.include_query_params(cursor=cursor)
        response.headers["Link"] = f'<{url.path}?{url.query}>; rel="next"'


async def _body(request: Request) -> bytes:
    """The body, up to the size limit, which the framework would report in plain text."""
    return await body_of(request, LONGEST_BODY)


RequestBody = Annotated[bytes, Depends(_body)]


async def _posted(request: Request, body: RequestBody, settings: AppSettings) -> Posted:
    """A document in the body, for a child process to read."""
    media_type = _media_type(request)
    if media_type not in PARSERS:
        raise UnsupportedMediaType(f"{media_type[:80]!r}; send one of: {', '.join(PARSERS)}")
    return Posted(media_type, body, settings.max_runs)


PostedDocument = Annotated[Posted, Depends(_posted)]


async def in_child(request: Request, call: Callable[[*Given], Made], *given: *Given) -> Made:
    """The result of a call in a child process; the request waits for it without a turn. Raises InvalidInput."""
    readers: Readers = request.app.state.readers
    async with turn_of(request).waiting(), readers.slot(request.state.caller.name):
        return await readers.run(call, *given)


@asynccontextmanager
async def submitting(request: Request) -> AsyncIterator[None]:
    """A block within which a sweep is expanded and stored: those of few requests are in memory at once."""
    readers: Readers = request.app.state.readers
    async with AsyncExitStack() as place:
        async with turn_of(request).waiting():
            await place.enter_async_context(readers.submission(request.state.caller.name))
        yield


async def _change(request: Request) -> SweepChange:
    """The change of a sweep in the body; raises InvalidInput."""
    if _media_type(request) not in ("application/json", "application/merge-patch+json"):
        raise UnsupportedMediaType(f"{_media_type(request)!r}; send application/json")
    document = read_json(await body_of(request, LONGEST_CHANGE))
    try:
        return SweepChange.model_validate(document)
    except ValidationError as error:
        found = {".".join(map(str, item["loc"])) or "document": item["input"] for item in error.errors()}
        limit = f"`priority` alone, an integer from {PRIORITIES[0]} to {PRIORITIES[-1]}"
        cure = 'send for example {"priority": -10}'
        findings = [Finding(field, shown(value), limit, cure) for field, value in found.items()]
        raise InvalidInput(findings, pointers={field: pointer(field, document) for field in found}) from None


PatchedSweep = Annotated[SweepChange, Depends(_change)]


def _media_type(request: Request) -> str:
    return request.headers.get("content-type", "").partition(";")[0].strip().lower()


Priority = Annotated[
    int, Query(ge=PRIORITIES[0], le=PRIORITIES[-1], description="Sweeps of smaller numbers are computed first")
]
KeepQuery = Annotated[
    Keep, Query(description="Files kept for each run: `numbers`, also the `final` state, or also the `film`")
]
IdempotencyKey = Annotated[
    str | None,
    Header(
        description="A text of your choice; repeating a request with its key returns the sweep of the first request"
    ),
]


async def submit(
    request: Request,
    sweep: ExpandedSweep,
    priority: int = 0,
    keep: Keep = Keep.FINAL,
    once: tuple[str, str] | None = None,
) -> SweepStatus:
    """Store a sweep of the caller, called within ``submitting``; raises InvalidInput, QuotaExceeded, KeyReused."""
    store: Store = request.app.state.store
    settings: Settings = request.app.state.settings
    caller: Caller = request.state.caller
    quota = None
    if not caller.may(Scope.ADMIN):
        quota = Quota(settings.quota_sweeps, settings.quota_runs, settings.quota_bytes)
    if keep is Keep.NUMBERS:
        sweep = replace(sweep, bytes=0)

    def stored() -> SweepStatus:
        of_the_key = () if quota is None else _of_the_key(settings, quota, sweep, priority, keep)
        findings = (*_of_the_machine(settings, sweep), *of_the_key)
        return store.sweeps.create(Submission(sweep, caller.name, priority, keep, once, quota, findings))

    return await run_in_threadpool(stored)


def check_priority(caller: Caller, priority: int) -> None:
    """Raise InvalidInput for a priority that passes the sweeps of others, unless the caller may give it."""
    if priority not in USUAL_PRIORITIES and not caller.may(Scope.ADMIN):
        raise InvalidInput([_too_urgent(priority)])


def _too_urgent(priority: int) -> Finding:
    limit = f"a whole number from {USUAL_PRIORITIES[0]} to {USUAL_PRIORITIES[-1]} for this key"
    return Finding("priority", str(priority), limit, f"ask for less, or use a key with the scope `{Scope.ADMIN}`")


def _of_the_machine(settings: Settings, sweep: ExpandedSweep) -> Iterator[Finding]:
    """Estimates beyond memory and disk."""
    needs = f"a run needs about {shown_size(sweep.memory)}"
    if sweep.memory > settings.memory_of_a_run:
        limit = f"{shown_size(settings.memory_of_a_run)} of memory for a run (WHIPPLE_MEMORY_LIMIT, WHIPPLE_WORKERS)"
        yield Finding("memory", needs, limit, "take a coarser resolution, or a geometry with more symmetry")
    free = 0
    with suppress(OSError):
        free = free_bytes(settings.data) - settings.disk_reserve
    if 0 < free < sweep.bytes:  # while the disk is full, or away, accepted sweeps wait for it
        files = f"its files take about {shown_size(sweep.bytes)}"
        limit = f"{shown_size(free)} of disk above the reserve (WHIPPLE_DISK_RESERVE)"
        yield Finding("disk", files, limit, "keep only `numbers`, delete sweeps, or ask for fewer runs")


def _of_the_key(settings: Settings, quota: Quota, sweep: ExpandedSweep, priority: int, keep: Keep) -> Iterator[Finding]:
    """Findings of a submission that only a key with the scope ``admin`` may send."""
    cure = f"ask for less, or use a key with the scope `{Scope.ADMIN}`"
    if len(sweep.points) > quota.runs:
        yield Finding("document", f"{len(sweep.points)} runs", f"at most {quota.runs} runs of one owner", cure)
    if sweep.bytes > quota.bytes:
        limit = f"at most {shown_size(quota.bytes)} of one owner"
        yield Finding("document", f"files of about {shown_size(sweep.bytes)}", limit, cure)
    if priority not in USUAL_PRIORITIES:
        yield _too_urgent(priority)
    if keep in at_least(Keep(settings.most_kept)) - {settings.most_kept}:
        yield Finding("keep", keep, f"at most `{settings.most_kept}` for this key", cure)


def _repeated(
    request: Request,
    body: RequestBody,
    priority: Priority = 0,
    keep: KeepQuery = Keep.FINAL,
    idempotency_key: IdempotencyKey = None,
) -> tuple[str, str] | None:
    """The idempotency key of a submission, and a digest of what it asks for; raises InvalidInput."""
    if idempotency_key is None:
        return None
    # The draft standard has quotes around it.
    key = re.sub(r'\A"(.*)"\Z', r"\1", idempotency_key, flags=re.S)
    if not IDEMPOTENCY_KEY.fullmatch(key):
        limit = "1 to 200 visible ASCII characters without spaces"
        raise InvalidInput([Finding("Idempotency-Key", shown(idempotency_key), limit, "write for example a UUID")])
    prefix = f"{_media_type(request)}\n{priority}\n{keep}\n".encode()
    return key, hashlib.sha256(prefix + body).hexdigest()


Idempotency = Annotated[tuple[str, str] | None, Depends(_repeated)]
