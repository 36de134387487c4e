"""Computes a run: problem, simulation, measurements on the way, balances, files. Imported by processes that solve."""

import json
import platform
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import asdict, replace
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np

from solver import PHYSICS_VERSION
from solver.checkpoint import Checkpointing
from solver.errors import WhippleError
from solver.jit import software
from solver.simulation import Outcome, simulate, threads_for
from studies import scenarios
from studies.films.film import Film
from studies.results import ENERGY_DRIFT_LIMIT, Progress, RunResult
from studies.runs.journal import Journal, Say
from studies.runs.observer import Observer
from studies.runs.run import Run, materials_of
from studies.scenarios import Setting
from studies.values.atomic import write_atomically, write_text
from studies.values.files import ANSWER, FILM, STATE

# Flagged, not failed. The hottest 0.1 % of mass of resolved perforations holds 3 to 9 % of the internal energy at the
# end; half of it means that single particles have run away.
HOTTEST_SHARE_FLAG = 0.5

FILM_SO_FAR = ".film.npz"  # in place of the suffix of the checkpoint


def execute(
    run: Run,
    directory: Path,
    progress: Callable[[Progress], None] | None = None,
    *,
    threads: int | None = None,
    checkpoint: Path | None = None,
    leave: Callable[[], bool] | None = None,
    saved: Callable[[int], object] | None = None,
    film: bool = False,
    say: Say | None = None,
) -> RunResult:
    """Compute a run; leaves ``result.json`` in the directory, and if it succeeded ``state.npz`` (and ``film.npz``).

    The solver's own verdict, an unphysical state, is a result with state "failed"; it is not raised. ``threads``
    (``solver.simulation.threads_for``) decide how long it takes, and no number. With ``checkpoint`` the run goes on
    from that file where it is this run's and this machine's, and writes it as it goes; the numbers are those of a run
    that never stopped. ``saved`` is told the step of each checkpoint that it writes or goes on from, and ``say`` each
    line of the run's log. Raises Interrupted once ``leave`` says so.
    """
    directory.mkdir(parents=True, exist_ok=True)
    started = datetime.now(UTC).isoformat(timespec="seconds")
    clock = time.perf_counter()
    resumed: list[str] = []
    log = Journal(say)

    def explain(sentence: str) -> None:
        resumed.append(sentence)
        log.say(sentence)

    def listen(news: Progress) -> None:
        log.progress(news)
        if progress:
            progress(news)

    made = provenance()
    try:
        watched = observer_of(run, listen, film=film)
        problem = watched.setting.problem
        threads = threads_for(sum(body.mass.size for body in problem.bodies), threads)
        made["threads"] = threads
        log.question(run, problem, made)
        kept = None
        if checkpoint:
            listeners = {"leave": leave, "saved": saved, "tell": explain}
            kept = _checkpointing(checkpoint, watched, listeners)
        result = _succeed(run, directory, watched, threads, kept)
    except WhippleError as error:
        result = RunResult(run.id, "failed", reason=str(error), failure=type(error).__name__)
    made |= {"started": started, "seconds": time.perf_counter() - clock}
    if resumed:
        made["checkpoint"] = "; ".join(resumed)
    result = replace(result, provenance=made)
    log.end(result)
    _write_result(directory, result)
    return result


def refuse(run_id: str, directory: Path) -> None:
    """Leave the result of a run that was submitted under another physics, or under other defaults: failed, with why.

    Its number is that of what was asked then; computed now, other numbers would stand under it.
    """
    directory.mkdir(parents=True, exist_ok=True)
    reason = (
        "this run was submitted to another version of whipple, and this one (physics "
        f"{PHYSICS_VERSION}) would not give its numbers; submit the sweep again"
    )
    _write_result(directory, RunResult(run_id, "failed", reason=reason, failure="OtherPhysics"))


def observer_of(
    run: Run, progress: Callable[[Progress], None] | None = None, *, film: bool = False
) -> Observer:
    """The observer of a run, with the problem that it is to watch."""
    scenario, setting = scenarios.load(run.scenario), setting_of(run)
    shown = Film(setting.problem) if film else None
    return Observer(scenario, scenario.parameters(**run.parameters), setting, progress, shown)


def setting_of(run: Run) -> Setting:
    """The problem of a run, and what an observer needs to know of it."""
    scenario = scenarios.load(run.scenario)
    return scenario.build(scenario.parameters(**run.parameters), materials_of(run))


def provenance() -> dict[str, str | float]:
    """What computed: versions and processor."""
    try:
        release = version("whipple")
    except PackageNotFoundError:
        release = "unknown"
    return {
        "whipple": release,
        "physics_version": str(PHYSICS_VERSION),
        "python": platform.python_version(),
        "numpy": np.__version__,
        **software(),
    }


def _checkpointing(
    path: Path, watched: Observer, listeners: Mapping[str, Callable[..., Any] | None]
) -> Checkpointing:
    """Checkpoints of the solver with what was read so far in them, and the film so far in a file beside."""
    film, so_far = watched.film, path.with_suffix(FILM_SO_FAR)

    def remember() -> str:
        if film:
            with suppress(OSError):  # no space: the film will begin where the run goes on
                film.save(so_far)
        frames = len(film.times) if film else 0
        return json.dumps({"observer": watched.remember(), "frames": frames})

    def recall(text: str) -> None:
        remembered = json.loads(text)
        watched.recall(remembered["observer"])
        if film:
            film.resume(so_far, remembered["frames"])

    given: dict[str, Any] = {name: one for name, one in listeners.items() if one is not None}
    return Checkpointing(
        path=path, caller=watched.definitions(), remember=remember, recall=recall, **given
    )


def _write_result(directory: Path, result: RunResult) -> None:
    write_text(directory / ANSWER, json.dumps(result.as_json(), allow_nan=False, indent=1))


def _succeed(
    run: Run,
    directory: Path,
    watched: Observer,
    threads: int | None,
    kept: Checkpointing | None,
) -> RunResult:
    outcome = simulate(
        watched.setting.problem,
        watched,
        interval=watched.pace.interval,
        threads=threads,
        checkpoint=kept,
    )
    numbers = _numbers(watched, outcome)
    _save_state(directory, outcome)
    if watched.film:
        watched.film.save(directory / FILM, compressed=True)
    return RunResult(
        run.id,
        "succeeded",
        measurements=watched.measured(),
        flags=_flags(numbers, watched.scenario.watch.least_cells),
        numbers=numbers,
        stop=outcome.stop,
    )


def _numbers(watched: Observer, outcome: Outcome) -> dict[str, float]:
    audit = outcome.audit
    counted = {name: float(count) for name, count in asdict(outcome.counters).items()}
    return {
        **watched.scenario.cells(watched.given),
        "particles": float(sum(body.mass.size for body in watched.setting.problem.bodies)),
        "particle_steps": float(outcome.particle_steps),
        "steps": float(outcome.snapshot.step),
        "end_time": outcome.snapshot.time,
        "smallest_step": outcome.smallest_step,
        "energy_drift": audit.energy_drift,
        "largest_energy_drift": max((a.energy_drift for a in outcome.history), key=abs),
        "momentum_error": audit.momentum_error,
        "mass_error": audit.mass_error,
        "removed_energy_fraction": audit.removed_energy,
        "contact_energy_fraction": audit.contact_energy,
        "outflow_mass_fraction": audit.outflow_mass,
        "outflow_energy_fraction": audit.outflow_energy,
        "hottest_energy_share": audit.hottest_energy_share,
        "largest_speed": audit.largest_speed,
        **watched.scenario.watch.numbers(watched.last_view),
        **counted,
    }


def _flags(numbers: Mapping[str, float], least_cells: Mapping[str, float]) -> tuple[str, ...]:
    flags = []
    if any(numbers[name] < least for name, least in least_cells.items()):
        flags.append("under_resolved")
    if abs(numbers["largest_energy_drift"]) > ENERGY_DRIFT_LIMIT:
        flags.append("energy_drift")
    if numbers["hottest_energy_share"] > HOTTEST_SHARE_FLAG:
        flags.append("runaway_particles")
    flags += [name for name in ("below_zero_kelvin", "beyond_hugoniot") if numbers[name] > 0.0]
    return tuple(flags)


def _save_state(directory: Path, outcome: Outcome) -> None:
    """The living particles of the final state, so that measurements can be read again, and records of the retired."""
    particles, living = outcome.snapshot.particles, outcome.snapshot.particles.alive == 1
    fields = {
        name: getattr(particles, name)[living] for name in particles._fields if name != "alive"
    }
    retired = outcome.snapshot.retired._asdict()
    fields.update({f"retired_{name}": array for name, array in retired.items()})

    def save(path: Path) -> None:
        with open(path, "wb") as file:
            np.savez_compressed(
                file, body=outcome.snapshot.body[living], time=outcome.snapshot.time, **fields
            )

    write_atomically(directory / STATE, save)
