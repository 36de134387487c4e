"""What child processes do for requests, within limits of time and memory: sweeps are read and expanded.

A body of some hundred bytes can ask for seconds of computing, for which the event loop must never wait. The children
load neither the web framework nor the store: results go back as records.
"""

import gc
import math
import os
import resource
import signal
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from threading import Timer
from types import FrameType
from typing import TypeVar, TypeVarTuple

from service import memory
from service.api.documents import pointer, read_json, read_yaml
from service.records.expansion import ExpandedSweep, expand
from studies.quantities.findings import Finding, InvalidInput
from studies.quantities.parameters import Plain
from studies.runs.run import Estimate, Run, estimate
from studies.sweeps.reading import SweepLimits
from studies.sweeps.sweep import Sweep

YAML = "application/yaml"
PARSERS: Mapping[str, Callable[[bytes], Plain]] = {
    "application/json": read_json,
    YAML: read_yaml,
    "application/x-yaml": read_yaml,
    "text/yaml": read_yaml,
}
GIVEN_BACK_SECONDS = 1.0  # after a document: what was made of it has been sent by then
NICENESS = 5  # nice(2) of a child: the process that answers requests comes first, and runs leave it a quarter of a core
Given = TypeVarTuple("Given")
Made = TypeVar("Made")


@dataclass(frozen=True)
class ReadingLimits:
    """What one request may take of a child."""

    cpu_seconds: int = 30  # ten thousand runs take 6 (2026-11)
    memory: int = 1 << 30  # bytes of data; ten thousand runs take 140 MB (2026-11)


USUAL = ReadingLimits()


class _OutOfTime(BaseException):
    """The computing time of a request is over; no handler of other errors may catch it."""


def within_limits(limits: ReadingLimits, call: Callable[[*Given], Made], *given: *Given) -> Made:
    """What a call makes of its arguments, within limits of time and memory; raises InvalidInput beyond them."""
    os.setpriority(os.PRIO_PROCESS, 0, NICENESS)
    # Ctrl-C is for the service, which ends its children.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGXCPU, _end)
    resource.setrlimit(resource.RLIMIT_DATA, (limits.memory, limits.memory))
    end = math.ceil(time.process_time()) + limits.cpu_seconds
    resource.setrlimit(resource.RLIMIT_CPU, (end, resource.RLIM_INFINITY))
    gc.disable()  # no cycles worth finding: looking for them takes a third of the time (2026-11)
    try:
        return call(*given)
    except _OutOfTime:
        raise _too_large(f"{limits.cpu_seconds} s of computing time") from None
    except MemoryError:
        raise _too_large(f"{limits.memory >> 20} MiB of memory") from None
    finally:
        gc.enable()
        gc.collect()
        with suppress(RuntimeError):  # no memory for a thread
            timer = Timer(GIVEN_BACK_SECONDS, memory.give_back)
            timer.daemon = True
            timer.start()


def _end(_signal: int, _frame: FrameType | None) -> None:
    raise _OutOfTime


def _too_large(limit: str) -> InvalidInput:
    cure = "split the sweep, or shorten the document"
    return InvalidInput([Finding("document", f"more than {limit}", f"at most {limit}", cure)])


@dataclass(frozen=True)
class Posted:
    """A body as it came, and the most runs that its sweep may have."""

    media_type: str  # one of ``PARSERS``
    body: bytes
    max_runs: int

    @contextmanager
    def document(self) -> Iterator[Plain]:
        """The document of the body for the duration of a block, whose errors get the places in the document."""
        document = PARSERS[self.media_type](self.body)
        try:
            yield document
        except InvalidInput as error:
            pointers = {finding.field: pointer(finding.field, document) for finding in error.findings}
            raise InvalidInput(error.findings, pointers=pointers) from None


def expanded(posted: Posted) -> ExpandedSweep:
    """The sweep of a body with its runs, to be stored; raises InvalidInput with every error."""
    with posted.document() as document:
        return expanded_sweep(Sweep.parse(document, SweepLimits(posted.max_runs)))


def expanded_sweep(checked: Sweep) -> ExpandedSweep:
    """A sweep with its runs, to be stored; raises InvalidInput."""
    estimates: list[Estimate] = []

    def cost(run: Run) -> float:
        estimates.append(estimate(run))
        return estimates[-1].core_seconds

    sweep = expand(checked, cost)
    largest = max((of_run.memory for of_run in estimates), default=0)
    size = sum(of_run.bytes for of_run in estimates)
    return replace(sweep, memory=largest, bytes=size, warnings=tuple(doubts_about(checked)))


def doubts_about(sweep: Sweep) -> list[str]:
    """Warn of what a sweep asks for and has little use of, in words."""
    from studies.sweeps.warnings import warnings_of  # with NumPy, which the parent of this child never loads

    return warnings_of(sweep)
