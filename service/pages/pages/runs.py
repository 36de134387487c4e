"""A run from the inside: what it measured and when, pictures of its matter, its parameters, log and files."""

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Annotated, Any
from zipfile import BadZipFile, ZipFile

from fastapi import APIRouter, Depends, Request, Response
from fastapi.responses import RedirectResponse
from starlette.concurrency import run_in_threadpool

from service.api.access import Reader, Submitter
from service.api.browsers import check_token
from service.api.dependencies import (
    AppArtifacts,
    AppSettings,
    AppStore,
    LocalArtifacts,
    RunId,
    in_child,
    submit,
    submitting,
)
from service.api.downloads import bring_back
from service.api.routes.runs import log_of
from service.api.schemas import FileModel, RunModel
from service.conversions.conversions import makers
from service.files.artifacts import LOG, Artifacts
from service.pages.charts import Chart
from service.pages.computed import alone, drawn_end
from service.pages.grid import in_words, printed, quantities_of, value_of
from service.pages.notes import note_on
from service.pages.page_routes import PageRoutes
from service.pages.rendering import SEE_OTHER, as_svg, drawn, page
from service.records.jobs import TERMINAL, VIEWS, Conflict, Keep, NotFound, RunPlace, RunRow, Scope, State, Stored
from service.store import Store
from studies import measurements, scenarios
from studies.quantities.display import digits, display_of, duration, kind_of, of_share, printed_beside
from studies.quantities.files import FILM, RESULT, SECTION_NOW, SECTIONS, STATE
from studies.quantities.measured import flags_in_words
from studies.quantities.parameters import Plain, Value, declared
from studies.reports.figure import Scale, Series
from studies.sweeps.reading import RESOLUTION

router = APIRouter(include_in_schema=False)
PAGE = PageRoutes("runs", 90, router)

MOST_SWEEPS = 5  # of a run, whose links are shown
LARGEST_RESULT = 2 << 20  # bytes of a result whose histories are drawn; usual are 20 kB
ENERGY, TIME = "energy", Scale("time", "time", "s")
LOG_BYTES = 4096  # of the end of a log
MOST_PLACES = 10  # sweeps of a run that are looked at
FILM_OF = "Film of a run of "  # the title of a film begins so
MOST_CHARTS = 24  # histories of measurements that are drawn
# What the row of a run says of how its numbers came to be.
COUNTED = {
    "cells_per_diameter": "cells across the diameter",
    "cells_per_thickness": "through the thickness",
    "particles": "particles",
    "steps": "steps",
}
DRIFT = "largest_energy_drift"
STOPS = {"settled": "when what it measures had settled", "end_time": "when its time was over"}


async def _files(id: RunId, request: Request, _: Reader, store: AppStore) -> Sequence[Stored]:
    """The files of a run, those that its page shows brought back from a bucket."""
    files = await run_in_threadpool(store.runs.files, id)
    await bring_back(request, *(file for file in files if file.name in (RESULT, LOG, SECTIONS)))
    return files


RunFiles = Annotated[Sequence[Stored], Depends(_files)]


def _histories(id: RunId, files: RunFiles, store: AppStore, artifacts: LocalArtifacts) -> dict[str, Chart]:
    """The charts of a run by name."""
    result = next((file for file in files if file.name == RESULT), None)
    if result is None or result.size > LARGEST_RESULT or not artifacts.may_be_shown(result):
        return {}
    return _charts(artifacts, result, store.runs.get(id).scenario)


Histories = Annotated[dict[str, Chart], Depends(_histories)]


@router.get("/runs/{id}")
def show_run(
    request: Request,
    id: RunId,
    caller: Reader,
    store: AppStore,
    artifacts: LocalArtifacts,
    files: RunFiles,
    histories: Histories,
) -> Response:
    """A run: its state, histories, pictures, parameters, log and files."""
    run, spec = store.runs.get(id), store.runs.spec(id)
    places = [(place, in_words(run.scenario, place.coordinates)) for place in store.runs.places(id, MOST_SWEEPS + 1)]
    names = {file.name for file in files}
    measured = list(_measured(run.scenario, (run.summary or {}).get("measurements", {}), spec["parameters"]))
    progress = run.progress if run.state in (State.RUNNING, State.CANCELLING) else None
    so_far = {name: {"value": value} for name, value in ((progress or {}).get("measured") or {}).items()}
    main = next((name for name in quantities_of(run.scenario) if name in histories), "")
    is_open = run.state not in TERMINAL
    return page(
        request,
        "run.html",
        caller,
        run=run,
        scenario=scenarios.load(run.scenario),
        places=places[:MOST_SWEEPS],
        point=next((words for _, words in places if words), ""),
        is_in_more=len(places) > MOST_SWEEPS,
        measured=measured,
        came_to_be=list(_came_to_be(run)),
        picture=_picture_address(id, files, artifacts),
        now=_now_address(run, store, artifacts),
        chart=histories[main].image(f"/runs/{id}/histories/{main}", {}) if main else "",
        so_far=list(_measured(run.scenario, so_far, spec["parameters"])),
        charts=[chart.image(f"/runs/{id}/histories/{name}", {}) for name, chart in histories.items() if name != main],
        views=[view for view, sources in VIEWS.items() if names & {*sources} and f"{view}.view" in makers()],
        has_film=FILM in names and "gif" in makers(),
        may_film=_lacks_film(run, files) and caller.may(Scope.SUBMIT),
        has_radiograph=_has_radiograph(artifacts, files, spec["parameters"]),
        parameters=list(_parameters(run.scenario, spec["parameters"], _asked(store, [place for place, _ in places]))),
        materials=spec["materials"],
        log=_log_end(store, artifacts, id),
        files=[FileModel.of(id, file) for file in files],
        links=RunModel.of(run).links,
        events=RunModel.of(run).links["events"] if is_open else None,
    )


def _picture_address(id: str, files: Iterable[Stored], artifacts: Artifacts) -> str:
    """The address of the picture of a run's end; empty without its sections."""
    sections = next((file for file in files if file.name == SECTIONS and artifacts.may_be_shown(file)), None)
    return f"/runs/{id}/picture?content={sections.sha256[:16]}" if sections else ""


def _section_now(run: RunRow, store: Store, artifacts: Artifacts) -> Path | None:
    """The file with the last section of a running run; None where there is none."""
    if run.state not in (State.RUNNING, State.CANCELLING):
        return None
    last = store.retention.last_attempts([run.id]).get(run.id)
    if last is None or last.token is None:
        return None
    file = artifacts.log_of(run.id, last.attempt, last.token).with_name(SECTION_NOW)
    return file if file.is_file() else None


def _now_address(run: RunRow, store: Store, artifacts: Artifacts) -> str:
    """The address of the picture of a running run, another one for each section; empty without any."""
    with suppress(OSError):
        if file := _section_now(run, store, artifacts):
            return f"/runs/{run.id}/now?at={file.stat().st_mtime:.0f}"
    return ""


@router.get("/runs/{id}/now")
async def show_now(request: Request, id: RunId, _: Reader, store: AppStore, artifacts: AppArtifacts) -> Response:
    """The last section of a running run: SVG."""
    run, spec = await run_in_threadpool(lambda: (store.runs.get(id), store.runs.spec(id)))
    file = await run_in_threadpool(_section_now, run, store, artifacts)
    if file is None:
        raise NotFound("picture", id)
    try:
        # Without lengths, about which its frame would be drawn: a hole is small at first.
        return as_svg(await in_child(request, drawn_end, str(file), run.scenario, spec["parameters"], {}))
    except OSError:  # the run has ended meanwhile
        raise NotFound("picture", id) from None


@router.get("/runs/{id}/picture")
async def show_picture(
    request: Request, id: RunId, files: RunFiles, store: AppStore, artifacts: LocalArtifacts
) -> Response:
    """The section of a run at its end, with what it measured: SVG."""
    if not _picture_address(id, files, artifacts):
        raise NotFound("picture", id)
    [sections] = [file for file in files if file.name == SECTIONS]
    run, spec = await run_in_threadpool(lambda: (store.runs.get(id), store.runs.spec(id)))
    measured = (run.summary or {}).get("measurements", {})
    lengths = {name: each["value"] for name, each in measured.items() if each.get("value") is not None}
    path = str(artifacts.path(sections))
    svg = await in_child(request, drawn_end, path, run.scenario, spec["parameters"], lengths)
    return as_svg(svg)


@router.get("/runs/{id}/histories/{name}")
async def show_history(request: Request, name: str, histories: Histories) -> Response:
    """A history of a run: SVG."""
    if name not in histories:
        raise NotFound("history", name[:80])
    return await drawn(request, histories[name])


@router.post("/runs/{id}/film", name="submit", dependencies=[Depends(check_token)])
async def compute_film(request: Request, id: RunId, _: Submitter, store: AppStore, settings: AppSettings) -> Response:
    """Compute a run again that kept no film, for a sweep of it alone that keeps one; its page shows it then."""
    place, document = await run_in_threadpool(_place, id, store)
    title = f"{FILM_OF}{place.title.removeprefix(FILM_OF)}"[:200]
    async with submitting(request):
        sweep = await in_child(request, alone, id, document, place.coordinates, title, settings.max_runs)
        if await run_in_threadpool(lambda: _lacks_film(store.runs.get(id), store.runs.files(id))):
            await submit(request, sweep, keep=Keep.FILM)
    return RedirectResponse(f"/runs/{id}", SEE_OTHER)


def _place(id: str, store: Store) -> tuple[RunPlace, Mapping[str, Plain]]:
    """The place of a run in the youngest of its sweeps, and the document of that; raises NotFound, Conflict."""
    store.runs.get(id)
    places = (place for place in store.runs.places(id, MOST_PLACES) if "screening" not in place.coordinates)
    place = next(places, None)
    if place is None:
        raise Conflict("no sweep has this run at a point of its axes any more; submit one that does")
    return place, store.sweeps.document(place.sweep_id)


def _lacks_film(run: RunRow, files: Iterable[Stored]) -> bool:
    """Whether a run has a result without a film, and none is under way."""
    return run.state is State.SUCCEEDED and all(file.name != FILM for file in files)


def _has_radiograph(artifacts: Artifacts, files: Iterable[Stored], parameters: Mapping[str, Value]) -> bool:
    """Whether there is the final state of an impact, upright and so the same from all sides, or else a radiograph."""
    named = {file.name: file for file in files}
    if STATE in named:
        return "projectile_diameter" in parameters and not parameters.get("obliquity")
    with suppress(KeyError, OSError, BadZipFile), ZipFile(artifacts.local(named[SECTIONS])) as archive:
        return "radiograph.npy" in archive.namelist()
    return False


@dataclass(frozen=True)
class PrintedNumber:
    """What a run measured, as people read it."""

    title: str
    meaning: str
    text: str
    bar: str
    unit: str
    flags: list[str]
    raw: str = ""  # what was read off, before the mesh error was taken off


def _measured(
    scenario: str, found: Mapping[str, Mapping[str, Any]], parameters: Mapping[str, Value]
) -> Iterator[PrintedNumber]:
    """What a run measured, or has measured so far, in the order of its scenario, as people read it."""
    for name in quantities_of(scenario):
        if name in found:
            uncertainty, flags = found[name].get("uncertainty"), found[name].get("flags", ())
            number = _printed(name, found[name].get("value"), uncertainty, flags, parameters)
            raw = found[name].get("raw")
            yield replace(number, raw="" if raw is None else printed(measurements.load(name), raw, uncertainty))


def _printed(
    name: str, value: float | None, uncertainty: float | None, flags: Sequence[str], parameters: Mapping[str, Value]
) -> PrintedNumber:
    measurement = measurements.load(name)
    text = printed(measurement, value, uncertainty)
    if value is not None and (note := note_on(name)) and (told := note.of_run(value, parameters)):
        text = f"{text}; {told}"
    return PrintedNumber(
        measurement.title,
        measurement.meaning,
        text,
        bar=printed_beside(uncertainty, kind_of(measurement.unit), uncertainty) if uncertainty else "",
        unit="" if measurement.is_outcome else display_of(measurement.unit).unit,
        flags=flags_in_words(flags),
    )


def _came_to_be(run: RunRow) -> Iterator[tuple[str, str]]:
    """How the numbers of a run came to be: what it is about, and words."""
    numbers = (run.summary or {}).get("numbers", {})
    counted = [
        f"{digits(value)} {words}" for name, words in COUNTED.items() if (value := numbers.get(name)) is not None
    ]
    if counted:
        yield "computed with", ", ".join(counted)
    if (drift := numbers.get(DRIFT)) is not None:
        yield "energy lost or gained", of_share(abs(drift))
    if stop := (run.summary or {}).get("stop"):
        yield "ended", STOPS.get(stop, stop)
    if run.seconds:
        yield "took", duration(run.seconds) + (f", attempt {run.attempt}" if run.attempt > 1 else "")


@lru_cache(maxsize=16)
def _charts(artifacts: Artifacts, result: Stored, scenario: str) -> dict[str, Chart]:
    """The histories of a result by name: energies, then measurements in the order of the scenario."""
    plain = json.loads(artifacts.path(result).read_bytes())
    charts = {ENERGY: _energies(plain["histories"], plain["histories"])} if plain.get("histories") else {}
    for name in [name for name in quantities_of(scenario) if name in plain.get("measurements", {})][:MOST_CHARTS]:
        history, measurement = plain["measurements"][name]["history"], measurements.load(name)
        if len(history["time"]) > 1:
            line = Series("history", measurement.title, tuple(history["time"]), tuple(history["value"]))
            y = Scale(name, measurement.title, measurement.unit)
            charts[name] = Chart(measurement.title, TIME, y, [line])
    return {name: chart for name, chart in charts.items() if not chart.is_empty}


def _energies(bodies: Mapping[str, Sequence[Sequence[float]]], histories: Mapping[str, Sequence[float]]) -> Chart:
    """Where the energy of all bodies is over time."""
    of_bodies = {"kinetic": "kinetic_energy", "internal": "internal_energy", "has left the grid": "departed_energy"}
    of_run = {"removed by contact": "contact_energy", "otherwise removed": "otherwise_removed_energy"}
    sums = {label: [sum(moment) for moment in zip(*bodies[name], strict=True)] for label, name in of_bodies.items()}
    sums |= {label: [*histories[name]] for label, name in of_run.items()}
    sums = {label: values for label, values in sums.items() if any(values)}
    sums["all together"] = [sum(moment) for moment in zip(*sums.values(), strict=True)]
    lines = [Series("history", label, tuple(histories["time"]), tuple(values)) for label, values in sums.items()]
    return Chart("Energy", TIME, Scale(ENERGY, "energy", "J"), lines)


def _asked(store: Store, places: Sequence[RunPlace]) -> set[str]:
    """The parameters that the youngest sweep of a run names."""
    if not places:
        return set()
    fixed = store.sweeps.document(places[0].sweep_id).get("fixed")
    return {*places[0].coordinates, *(fixed if isinstance(fixed, dict) else {}), RESOLUTION}


@dataclass(frozen=True)
class PrintedParameter:
    """A parameter of a run as people read it, and whether its sweep asked for its value."""

    name: str
    text: str
    meaning: str
    asked: bool


def _parameters(scenario: str, parameters: Mapping[str, Value], asked: set[str]) -> Iterator[PrintedParameter]:
    described = declared(scenarios.load(scenario).parameters)
    for name, value in parameters.items():
        meaning = described[name].meaning if name in described else ""
        yield PrintedParameter(name, value_of(scenario, name, value), meaning, name in asked)


def _log_end(store: Store, artifacts: Artifacts, id: str) -> str:
    """The last lines of the log of a run; empty without one."""
    try:
        file, registered = log_of(id, store, artifacts)
        if registered is not None and not artifacts.may_be_shown(registered):
            return ""
        with file.open("rb") as log:
            log.seek(max(0, file.stat().st_size - LOG_BYTES))
            text = log.read(LOG_BYTES).decode(errors="replace")
    except (NotFound, OSError):
        return ""
    return text if file.stat().st_size <= LOG_BYTES else text.partition("\n")[2]
