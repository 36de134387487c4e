"""Documents of requests in a child process: sweeps, read, priced and expanded, and questions to laws, each within
limits of time and memory.

A body of some hundred bytes can ask for seconds of computing, for which the event loop must never wait. The children
load neither the web framework nor the store: results go back as records.
"""

import gc
import json
import math
import os
import resource
import signal
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from threading import Timer
from types import FrameType
from typing import Any, TypeVar

from markupsafe import Markup

from service import memory
from service.api.documents import pointer, read_json, read_yaml
from service.records.expansion import ExpandedSweep, expand, expand_again
from studies.quantities.findings import Finding, InvalidInput
from studies.runs.run import Estimate, Run, estimate
from studies.sweeps.cost import PresetCost, SweepCost, presets_of, sweep_cost
from studies.sweeps.longer import with_values
from studies.sweeps.reading import ACCEPTED, SweepLimits
from studies.sweeps.sweep import Sweep

PARSERS: Mapping[str, Callable[[bytes], Any]] = {
    "application/json": read_json,
    "application/yaml": read_yaml,
    "application/x-yaml": read_yaml,
    "text/yaml": read_yaml,
}
GIVEN_BACK_SECONDS = 1.0  # after a document: what was made of it has been sent by then
NICENESS = 5  # nice(2) of a child: the process that answers requests comes first, and runs leave it a quarter of a core
Read = TypeVar("Read")


@dataclass(frozen=True)
class Posted:
    """A body as it came, and the most runs that its sweep may have."""

    media_type: str  # one of ``PARSERS``
    body: bytes
    max_runs: int


@dataclass(frozen=True)
class ReadingLimits:
    """What one sweep may take of a child."""

    cpu_seconds: int = 30  # ten thousand runs take 6 (2026-11)
    memory: int = 1 << 30  # bytes of data; ten thousand runs take 140 MB (2026-11)


USUAL = ReadingLimits()


@dataclass(frozen=True)
class EstimatedSweep:
    scenario: str
    cost: SweepCost
    warnings: list[str]
    presets: list[PresetCost]


@dataclass(frozen=True)
class Refusal:
    """The errors of a body, and where its document has them; exceptions lose both between processes."""

    findings: tuple[Finding, ...]
    pointers: Mapping[str, str]  # JSON pointers by field


class _OutOfTime(BaseException):
    """The computing time of a sweep is over; no handler of other errors may catch it."""


def read_within_limits(posted: Posted, part: Callable[[Any, Posted], Read], limits: ReadingLimits) -> Read | Refusal:
    """Read a body within limits of time and memory."""
    os.setpriority(os.PRIO_PROCESS, 0, NICENESS)
    # Ctrl-C is for the service, which ends its children.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGXCPU, _end)
    resource.setrlimit(resource.RLIMIT_DATA, (limits.memory, limits.memory))
    end = math.ceil(time.process_time()) + limits.cpu_seconds
    resource.setrlimit(resource.RLIMIT_CPU, (end, resource.RLIM_INFINITY))
    gc.disable()  # no cycles worth finding: looking for them takes a third of the time (2026-11)
    try:
        return read(posted, part)
    except _OutOfTime:
        return _too_large(f"{limits.cpu_seconds} s of computing time")
    except MemoryError:
        return _too_large(f"{limits.memory >> 20} MiB of memory")
    finally:
        gc.enable()
        gc.collect()
        with suppress(RuntimeError):  # no memory for a thread
            timer = Timer(GIVEN_BACK_SECONDS, memory.give_back)
            timer.daemon = True
            timer.start()


def _end(_signal: int, _frame: FrameType | None) -> None:
    raise _OutOfTime


def _too_large(limit: str) -> Refusal:
    cure = "split the sweep, or shorten the document"
    return Refusal((Finding("document", f"more than {limit}", f"at most {limit}", cure),), {})


def read(posted: Posted, part: Callable[[Any, Posted], Read]) -> Read | Refusal:
    """Read a body and make something of its document."""
    document = None
    try:
        document = PARSERS[posted.media_type](posted.body)
        return part(document, posted)
    except InvalidInput as error:
        fields = {finding.field for finding in error.findings}
        return Refusal(error.findings, {field: pointer(field, document) for field in fields})


def expanded(document: Any, posted: Posted) -> ExpandedSweep:
    """The sweep with its runs, to be stored."""
    checked = _sweep(document, posted)
    estimates: list[Estimate] = []

    def cost(run: Run) -> float:
        estimates.append(estimate(run))
        return estimates[-1].core_seconds

    sweep = expand(checked, cost)
    memory = max((each.memory for each in estimates), default=0)
    size = sum(each.bytes for each in estimates)
    return replace(sweep, memory=memory, bytes=size, warnings=tuple(_warnings(checked)))


def expanded_anew(document: Any, _posted: Posted) -> ExpandedSweep:
    """A sweep that an older version accepted, with its runs of this one."""
    return expand_again(document)


def longer(change: Any, posted: Posted) -> ExpandedSweep:
    """A sweep with further values on one of its axes; those of ``change`` are texts separated by commas."""
    values = [_number_or_text(value.strip()) for value in change["values"].split(",")]
    sweep = with_values(Sweep.parse(change["sweep"], ACCEPTED), change["axis"], values)
    # Once more, under the limits of a sweep that is posted.
    return expanded(sweep.document(), posted)


def alone(change: Any, posted: Posted) -> ExpandedSweep:
    """The sweep of a single run of a sweep, at some coordinates."""
    sweep = Sweep.parse(change["sweep"], ACCEPTED)
    if {*change["at"]} < {axis.name for axis in sweep.axes}:  # a run that screens the models
        cure = "submit a sweep with these parameters"
        raise InvalidInput([Finding("run", change["run"], "a run at a point of the axes of its sweep", cure)])
    single = expanded(replace(sweep.of_point(change["at"]), title=change["title"]).document(), posted)
    if single.points[0].run_id != change["run"]:
        cure = "submit its sweep again: results of different versions stay separate"
        raise InvalidInput([Finding("run", change["run"], "a run of this version of the physics", cure)])
    return single


def _number_or_text(text: str) -> Any:
    try:
        return float(text) if "." in text else int(text)
    except ValueError:
        return text


def estimated(document: Any, posted: Posted) -> EstimatedSweep:
    sweep = _sweep(document, posted)
    cost = sweep_cost(sweep)
    return EstimatedSweep(sweep.scenario, cost, _warnings(sweep), [*presets_of(sweep, posted.max_runs)])


def _warnings(sweep: Sweep) -> list[str]:
    from studies.sweeps.warnings import warnings_of  # with NumPy, which the parent of this child never loads

    return warnings_of(sweep)


def _sweep(document: Any, posted: Posted) -> Sweep:
    return Sweep.parse(document, SweepLimits(max_runs=posted.max_runs))


def answered(document: Any, _posted: Posted) -> bytes:
    """What laws and shots say of the shots of a question, as JSON."""
    from studies.answers import answer, question

    return json.dumps(answer.document(question.read_question(document)), ensure_ascii=False).encode()


def answered_as_cube(document: Any, _posted: Posted) -> bytes:
    """The same as NetCDF-4."""
    from studies.answers import cube, question

    return cube.netcdf(question.read_question(document))


def drawn_material(document: Any, _posted: Posted) -> list[tuple[str, str]]:
    """The pictures of a material that ships, each with its title, as images."""
    from studies import materials
    from studies.reports.drawing.images import as_image
    from studies.reports.drawing.material import drawings

    return [(title, as_image(drawing)) for title, drawing in drawings(materials.load(document["name"]))]


def drawn_chart(document: Any, _posted: Posted) -> str:
    """A line chart of a live page (``pages.charts``) as SVG."""
    from studies.reports.drawing.charts import lines
    from studies.reports.drawing.images import as_files

    [svg] = as_files(lines(document))
    return svg


@dataclass(frozen=True)
class AnsweredForm:
    """What laws and shots say of the shot of a form, as HTML; or what is wrong with the form."""

    findings: tuple[Finding, ...]
    headline: str = ""
    body: str = ""
    sheet: str = ""  # the same as a page by itself


def answered_form(document: Any, _posted: Posted) -> AnsweredForm:
    """The answer to the shot of a form, whose fields have one value each."""
    from studies.answers import answer, page, question
    from studies.reports.drawing.charts import of_page
    from studies.reports.drawing.images import as_images

    try:
        asked = question.read_question(document)
    except InvalidInput as error:
        return AnsweredForm(error.findings)

    def drawn(figure: Any) -> Markup:
        images = zip(("wide", "narrow"), as_images(of_page(figure, "answer")), strict=True)
        tag = '<img class="chart {}" src="{}" alt="{}">'
        return Markup("").join(Markup(tag).format(width, image, figure.title) for width, image in images)

    [given] = answer.answers(asked)
    shot = asked.shot(asked.fixed)
    return AnsweredForm((), given.headline(), page.body(given, shot, drawn), page.page(given, shot))
