"""What one owner may take of the service: requests a minute, and what a submission may ask for.

A key without the scope ``admin`` has quotas. Requests are counted in windows of a minute. Every response to such a key
has the RateLimit fields of draft-ietf-httpapi-ratelimit-headers-10: ``RateLimit-Policy: "requests";q=6000;w=60``, and
``RateLimit: "requests";r=5999;t=42`` with the requests that remain and the seconds until all are there again.
"""

import math
import time
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import replace
from threading import Lock

from service.api.access import Caller
from service.api.errors import RequestError
from service.files.disk_space import free_bytes, shown_size
from service.records.expansion import ExpandedSweep
from service.records.jobs import USUAL_PRIORITIES, Keep, Quota, Scope, Submission, at_least
from service.settings import Settings
from studies.quantities.findings import Finding, InvalidInput

WINDOW = 60.0  # s


class TooFast(RequestError, status=429, title="Too many requests a minute"):
    """This key has sent as many requests within a minute as the service allows; wait for `Retry-After` seconds."""

    def __init__(self, text: str, headers: Mapping[str, str]):
        super().__init__(text)
        self.headers = headers


class RequestRates:
    """Requests of each owner in its window."""

    def __init__(self, quota: int):
        self._quota = quota
        self._mutex = Lock()
        self._windows: dict[str, tuple[float, int]] = {}  # by owner: end (monotonic), requests

    def count(self, owner: str) -> Mapping[str, str]:
        """Count a request; the fields of its response. Raises TooFast."""
        now = time.monotonic()
        with self._mutex:
            end, requests = self._windows.get(owner, (0.0, 0))
            if now >= end:
                end, requests = now + WINDOW, 0
            self._windows[owner] = end, requests + 1
        left, seconds = max(0, self._quota - requests - 1), math.ceil(end - now)
        fields = {
            "RateLimit-Policy": f'"requests";q={self._quota};w={WINDOW:.0f}',
            "RateLimit": f'"requests";r={left};t={seconds}',
        }
        if requests >= self._quota:
            text = f"{requests + 1} requests of {owner!r} within {WINDOW:.0f} s; the quota is {self._quota}"
            raise TooFast(text, {**fields, "Retry-After": str(seconds)})
        return fields


def submission_of(
    settings: Settings,
    caller: Caller,
    sweep: ExpandedSweep,
    priority: int = 0,
    keep: Keep = Keep.FINAL,
    idempotency: tuple[str, str] | None = None,
) -> Submission:
    """A sweep of a caller with its options and quota; raises InvalidInput for what waiting does not help."""
    quota = None
    if not caller.may(Scope.ADMIN):
        quota = Quota(settings.quota_sweeps, settings.quota_runs, settings.quota_bytes)
    if keep is Keep.NUMBERS:
        sweep = replace(sweep, bytes=0)
    findings = [*_of_the_machine(settings, sweep)]
    if quota is not None:
        findings += _of_the_key(settings, quota, sweep, priority, keep)
    if findings:
        raise InvalidInput(findings)
    return Submission(sweep, caller.name, priority, keep, idempotency, quota)


def _of_the_machine(settings: Settings, sweep: ExpandedSweep) -> Iterator[Finding]:
    """Estimates beyond memory and disk."""
    needs = f"a run needs about {shown_size(sweep.memory)}"
    if sweep.memory > settings.memory_of_a_run:
        limit = f"{shown_size(settings.memory_of_a_run)} of memory for a run (WHIPPLE_MEMORY_LIMIT, WHIPPLE_WORKERS)"
        yield Finding("memory", needs, limit, "take a coarser resolution, or a geometry with more symmetry")
    free: float = math.inf
    with suppress(OSError):  # the disk is away, and the sweep waits until it is back
        free = max(0, free_bytes(settings.data) - settings.disk_reserve)
    if sweep.bytes > free:
        files = f"its files take about {shown_size(sweep.bytes)}"
        limit = f"{shown_size(free)} of disk above the reserve (WHIPPLE_DISK_RESERVE)"
        yield Finding("disk", files, limit, "keep only `numbers`, delete sweeps, or ask for fewer runs")


def _of_the_key(settings: Settings, quota: Quota, sweep: ExpandedSweep, priority: int, keep: Keep) -> Iterator[Finding]:
    """What a key without the scope ``admin`` may not ask for, however long it waits."""
    cure = f"ask for less, or use a key with the scope `{Scope.ADMIN}`"
    if len(sweep.points) > quota.runs:
        yield Finding("document", f"{len(sweep.points)} runs", f"at most {quota.runs} runs of one owner", cure)
    if sweep.bytes > quota.bytes:
        limit = f"at most {shown_size(quota.bytes)} of one owner"
        yield Finding("document", f"files of about {shown_size(sweep.bytes)}", limit, cure)
    if priority not in USUAL_PRIORITIES:
        limit = f"a whole number from {USUAL_PRIORITIES[0]} to {USUAL_PRIORITIES[-1]} for this key"
        yield Finding("priority", str(priority), limit, cure)
    if keep in at_least(settings.most_kept) - {settings.most_kept}:
        yield Finding("keep", keep, f"at most `{settings.most_kept}` for this key", cure)
