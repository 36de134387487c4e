"""Computes a run: problem, simulation, measurements on the way, balances, files. Imported by processes that solve."""

import json
import math
import platform
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import numpy as np

from solver import PHYSICS_VERSION
from solver.audit import BodyBalance, Exchanged
from solver.checkpoints import (
    Checkpointing,
    CheckpointRefused,
    Fingerprint,
    fingerprint,
    read_checkpoint,
    write_checkpoint,
)
from solver.errors import WhippleError
from solver.jit import software
from solver.problem import Problem
from solver.registry import points
from solver.simulation import DEPARTED, Outcome, simulate, threads_for
from solver.state import MASS, Snapshot
from studies import scenarios
from studies.measurements import distributions
from studies.quantities.files import FILM, RESULT, SECTION_NOW, SECTIONS, STATE, write_atomically, write_text
from studies.quantities.measured import ENERGY_DRIFT_LIMIT, LOST_PARTICLES, UNDER_RESOLVED
from studies.runs.observer import FilmRecorder, RunObserver
from studies.runs.results import (
    NO_CONTROL,
    OTHER_PHYSICS,
    Progress,
    ReadDistribution,
    RunControl,
    RunResult,
    with_mesh_errors,
)
from studies.runs.run import Run
from studies.runs.run_log import RunLog
from studies.runs.stages import EARLIER_STAGE, carried_by, outcome_of, setting_of, together
from studies.scenarios import Setting
from studies.sections.section import SectionRecorder, Watched

# Flagged, not failed. The hottest 0.1 % of the particles of resolved perforations hold 1 to 6 % of the internal energy
# at the end (case ``energy``); half of it means that single particles have run away.
HOTTEST_SHARE_FLAG = 0.5

# Flagged, not failed: more of the initial mass than this left a grid while its own pressure still drove it apart.
EXPANDING_FLAG = 0.01
# Of the mass: more that is hot enough to vaporise, and a form without vapour is no longer its equation of state.
VAPORISED_FLAG = 1e-3

# In place of the suffix of the checkpoint.
UNFINISHED_FILM, UNFINISHED_SECTIONS, ENDED_STAGE = ".film.npz", ".sections.npz", ".stage-{}"


def execute(
    run: Run,
    directory: Path,
    control: RunControl = NO_CONTROL,
    *,
    threads: int | None = None,
    checkpoint: Path | None = None,
    film: bool = False,
) -> RunResult:
    """Compute a run; leaves ``result.json`` in the directory, and if it succeeded ``state.npz`` and ``sections.npz``
    (and ``film.npz``).

    An unphysical state that the solver finds is a result with state "failed"; it is not raised. ``threads``
    (``solver.simulation.threads_for``) decide how long it takes, and no number. With ``checkpoint`` the run goes on
    from that file where it is this run's and this machine's, and writes it as it goes; the numbers are those of a run
    that never stopped. Raises Interrupted once ``control.must_stop`` is true.
    """
    directory.mkdir(parents=True, exist_ok=True)
    started = datetime.now(UTC).isoformat(timespec="seconds")
    clock = time.perf_counter()
    log = RunLog(control.log)
    made_by = provenance()
    resumptions: list[str] = []

    def report(progress: Progress) -> None:
        log.progress(progress)
        control.progress(progress)

    def explain(sentence: str) -> None:
        resumptions.append(sentence)
        control.log(sentence)

    try:
        observer = observer_of(run, report, film=film)
        observer.watched = Watched(directory / SECTION_NOW)
        problem = observer.setting.problem
        made_by["threads"] = threads_for(problem.particle_count, threads)
        log.begin(run, problem, made_by)
        outcomes = _stages(run, observer, log, threads, _Restart(checkpoint, control, explain))
        result = with_mesh_errors(run, _succeeded(run.id, directory, observer, outcomes))
    except WhippleError as error:
        result = RunResult(run.id, "failed", reason=str(error), failure=type(error).__name__)
    finally:
        (directory / SECTION_NOW).unlink(missing_ok=True)
    made_by |= {"started": started, "seconds": time.perf_counter() - clock}
    if resumptions:
        made_by["checkpoint"] = "; ".join(resumptions)
    result = replace(result, provenance=made_by)
    log.end(result)
    _write_result(directory, result)
    return result


def refuse(run_id: str, directory: Path) -> None:
    """Write a failed result for a run that was submitted to another version of physics or defaults.

    Its id names the numbers of that version; this version would store other numbers under it.
    """
    directory.mkdir(parents=True, exist_ok=True)
    reason = (
        "this run was submitted to another version of whipple, and this one (physics "
        f"{PHYSICS_VERSION}) would not give its numbers; retry the sweep, which expands it anew"
    )
    _write_result(directory, RunResult(run_id, "failed", reason=reason, failure=OTHER_PHYSICS))


def observer_of(run: Run, report: Callable[[Progress], object] | None = None, *, film: bool = False) -> RunObserver:
    """The observer of a run, with the problem that it observes."""
    scenario, setting = scenarios.load(run.scenario), setting_of(run)
    frames = film_of(run, setting) if film else None
    return RunObserver(scenario, run.set_up, setting, report, frames)


def film_of(run: Run, setting: Setting) -> FilmRecorder | None:
    """The film of a stage: the one that a run keeps is that of its last. None where no feature makes films."""
    interval = run.parameters.get("film_interval")
    for point in points("studies.runs.films"):
        film: type[FilmRecorder] = point.load()
        return film(setting.problem, interval=interval)  # type: ignore[arg-type]
    return None


def provenance() -> dict[str, str | float]:
    """Versions and processor of this process."""
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


@dataclass(frozen=True)
class _Restart:
    """Where a run keeps what it needs to go on, and whom it tells."""

    checkpoint: Path | None
    control: RunControl
    explain: Callable[[str], object]

    def read(self, observer: RunObserver, number: int) -> Outcome | None:
        """The end of a stage where it is stored; its observer then has read what it had by then."""
        if self.checkpoint is None:
            return None
        try:
            stored = read_checkpoint(self._ended(number), _mark(observer))
        except FileNotFoundError:
            return None
        except (CheckpointRefused, OSError) as error:
            self.explain(f"from the start of stage {number}, without its stored end: {error}")
            return None
        observer.restore(stored.numbers["observed"])
        self.explain(f"from the end of stage {number}")
        return outcome_of(stored)

    def write(self, observer: RunObserver, number: int, outcome: Outcome) -> None:
        """Store the end of a stage that another one follows; the checkpoint of its middle is of no more use."""
        if self.checkpoint is None:
            return
        try:
            write_checkpoint(self._ended(number), _mark(observer), carried_by(outcome, observer.as_text()))
            self.checkpoint.unlink(missing_ok=True)
        except OSError as error:
            self.explain(f"the end of stage {number} could not be stored: {error}")

    def _ended(self, number: int) -> Path:
        assert self.checkpoint is not None
        return self.checkpoint.with_suffix(ENDED_STAGE.format(number))


def _mark(observer: RunObserver) -> Fingerprint:
    return fingerprint(observer.setting.problem, caller=observer.definitions())


def _stages(run: Run, observer: RunObserver, log: RunLog, threads: int | None, restart: _Restart) -> list[Outcome]:
    """The outcomes of the stages of a run, each of which follows from the end of the one before."""
    outcomes: list[Outcome] = []
    following: Setting | None = observer.setting
    while following is not None:
        setting, number = following, len(outcomes) + 1
        if outcomes:
            observer.begin(setting, film_of(run, setting) if observer.film else None)
            log.stage(setting.problem, number)
        outcome = restart.read(observer, number) if number < observer.parameters.stages else None
        outcomes.append(outcome or _stage(observer, threads, restart))
        observer.steps_before += outcomes[-1].snapshot.step
        following = observer.parameters.next_stage(setting, outcomes[-1], run.materials)
        if following is not None and outcome is None:
            restart.write(observer, number, outcomes[-1])
    return outcomes


def _stage(observer: RunObserver, threads: int | None, restart: _Restart) -> Outcome:
    """The outcome of the stage that an observer has begun with."""
    problem, interval, checkpoint = observer.setting.problem, observer.rate.interval, restart.checkpoint
    observer.sections = SectionRecorder(problem, observer.parameters.sections(observer.setting), interval)
    return simulate(
        problem,
        observer,
        interval=interval,
        recorder=observer.film,
        threads=threads,
        checkpoint=_checkpointing(checkpoint, observer, restart.control, restart.explain) if checkpoint else None,
    )


def _checkpointing(
    path: Path, observer: RunObserver, control: RunControl, explain: Callable[[str], object]
) -> Checkpointing:
    """Checkpoints of the solver with the readings so far in them, and the film so far in a file beside."""
    film, film_file = observer.film, path.with_suffix(UNFINISHED_FILM)
    sections, sections_file = observer.sections, path.with_suffix(UNFINISHED_SECTIONS)

    def state_text() -> str:
        if film:
            with suppress(OSError):  # no space: the film will begin where the run goes on
                film.save(film_file)
        if sections and not sections.is_saved:
            with suppress(OSError):  # no space: the report will say that they were not kept
                sections.save(sections_file)
        frames = len(film.times) if film else 0
        return json.dumps({"observer": observer.as_text(), "frames": frames})

    def restore(text: str) -> None:
        stored = json.loads(text)
        observer.restore(stored["observer"])
        if film:
            film.resume(film_file, stored["frames"])
        if sections:
            sections.resume(sections_file)

    return Checkpointing(
        path=path,
        caller=observer.definitions(),
        observer_state=state_text,
        restore_observer=restore,
        must_stop=control.must_stop,
        on_checkpoint=lambda step: control.checkpointed(observer.steps_before + step),
        log=explain,
    )


def _write_result(directory: Path, result: RunResult) -> None:
    write_text(directory / RESULT, json.dumps(result.as_json(), allow_nan=False, indent=1))


def _succeeded(run_id: str, directory: Path, observer: RunObserver, outcomes: Sequence[Outcome]) -> RunResult:
    """The result of a simulation whose stages ended; writes its final state and its film."""
    outcome = together(outcomes)
    numbers, measured = _numbers(observer, outcome), observer.measured()
    lost = [name for name, one in measured.items() if LOST_PARTICLES in one.flags]
    _save_state(directory, outcome, outcomes[:-1])
    if observer.film:
        observer.film.save(directory / FILM, compressed=True)
    if observer.sections:
        observer.sections.end(outcome.snapshot)
        observer.sections.save(directory / SECTIONS)
    return RunResult(
        run_id,
        "succeeded",
        reason=f"{LOST_PARTICLES}: no {', '.join(lost)}" if lost else None,
        measurements=measured,
        flags=(*_flags(numbers, observer.scenario.least_cells), *((LOST_PARTICLES,) if lost else ())),
        numbers=numbers,
        stop=outcome.stop,
        histories=_histories([setting for setting, _ in observer.stages], outcomes),
        distributions=_distributions(observer),
    )


def _distributions(observer: RunObserver) -> dict[str, ReadDistribution]:
    """The distributions of the scenario, read off the last state."""
    read = [distributions.load(name) for name in observer.scenario.distributions]
    return {one.name: {"version": one.version, "values": one.read(observer.last_view).tolist()} for one in read}


def _histories(settings: Sequence[Setting], outcomes: Sequence[Outcome]) -> dict[str, Sequence[object]]:
    """Energy, momentum and what was exchanged over time (``studies.cubes.audit.HISTORIES``), of whole bodies."""
    wholes = [2.0 * math.pi / setting.sector for setting in settings]
    audits = [(whole, audit) for whole, ended in zip(wholes, outcomes, strict=True) for audit in ended.history]
    bodies = settings[-1].problem.bodies

    def of_bodies(pick: Callable[[BodyBalance], float]) -> list[list[float]]:
        # A body of a later stage is not there before.
        return [
            [whole * pick(audit.bodies[body]) if body < len(audit.bodies) else 0.0 for whole, audit in audits]
            for body in range(len(bodies))
        ]

    def of_run(pick: Callable[[Exchanged], float]) -> list[float]:
        return [whole * pick(audit.exchanged) for whole, audit in audits]

    return {
        "time": [audit.time for _, audit in audits],
        "bodies": [body.name for body in bodies],
        "kinetic_energy": of_bodies(lambda body: body.kinetic),
        "internal_energy": of_bodies(lambda body: body.internal),
        "departed_energy": of_bodies(lambda body: body.departed_kinetic + body.departed_internal),
        "axial_momentum": of_bodies(lambda body: body.momentum),
        "departed_axial_momentum": of_bodies(lambda body: body.departed_momentum),
        "contact_energy": of_run(lambda given: given.removed_by_contact),
        "otherwise_removed_energy": of_run(lambda given: given.removed - given.removed_by_contact),
        "load_work": of_run(lambda given: given.worked),
        "axial_impulse": of_run(lambda given: given.impulse),
    }


def _numbers(observer: RunObserver, outcome: Outcome) -> dict[str, float]:
    audit = outcome.audit
    counted = {name: float(count) for name, count in asdict(outcome.counters).items()}
    return {
        **observer.parameters.cells(),
        "particles": float(sum(body.mass.size for setting, _ in observer.stages for body in setting.problem.bodies)),
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
        "expanding_mass_fraction": audit.expanding_mass,
        "discarded_mass_fraction": audit.discarded_mass,
        "load_work": 2.0 * math.pi / observer.setting.sector * audit.exchanged.worked,
        "hottest_energy_share": audit.hottest_energy_share,
        "largest_speed": audit.largest_speed,
        **heated_fractions(observer.setting.problem, outcome.snapshot),
        **observer.parameters.numbers(observer.last_view),
        **counted,
    }


def heated_fractions(problem: Problem, snapshot: Snapshot) -> dict[str, float]:
    """Molten mass once all has expanded to no pressure, and mass that then vaporises, over that of the last stage."""
    from solver.matter.melting import melted_mass, residual_energy

    particles, departed = snapshot.particles, snapshot.departed
    molten = vaporised = 0.0
    for number, body in enumerate(problem.bodies):
        mine, late = snapshot.body == number, departed.body == number
        state = (getattr(particles, name)[mine] for name in ("density", "energy", "pressure"))
        residual = np.concatenate([residual_energy(body.matter.eos, *state), departed.energy[late]])
        mass = np.concatenate([particles.mass[mine], departed.mass[late]])
        molten += melted_mass(body.matter, residual, mass)
        vaporised += float(mass[residual > body.matter.melting.vaporisation].sum())
    coming = 0.0 if problem.arrivals is None else float(problem.arrivals.table[MASS].sum())
    whole = float(sum(body.mass.sum() for body in problem.bodies)) + coming
    return {"molten_mass_fraction": molten / whole, "vaporised_mass_fraction": vaporised / whole}


def _flags(numbers: Mapping[str, float], least_cells: Mapping[str, float]) -> tuple[str, ...]:
    flags = []
    if any(numbers[name] < least for name, least in least_cells.items()):
        flags.append(UNDER_RESOLVED)
    if abs(numbers["largest_energy_drift"]) > ENERGY_DRIFT_LIMIT:
        flags.append("energy_drift")
    if numbers["hottest_energy_share"] > HOTTEST_SHARE_FLAG:
        flags.append("runaway_particles")
    if numbers["expanding_mass_fraction"] > EXPANDING_FLAG:
        flags.append("still_expanding")
    if numbers["vaporised_mass_fraction"] > VAPORISED_FLAG:
        flags.append("vaporised")
    if numbers["discarded"] > 0.0:
        flags.append("discarded_particles")
    flags += [name for name in ("below_zero_kelvin", "beyond_hugoniot") if numbers[name] > 0.0]
    return tuple(flags)


def _save_state(directory: Path, outcome: Outcome, earlier: Sequence[Outcome]) -> None:
    """The living particles of the final state, the departed, and the ends of earlier stages."""
    particles, living = outcome.snapshot.particles, outcome.snapshot.particles.alive == 1
    fields = {name: getattr(particles, name)[living] for name in particles._fields if name != "alive"}
    departed = outcome.snapshot.departed._asdict()
    fields.update({DEPARTED + name: array for name, array in departed.items()})
    for number, ended in enumerate(earlier, 1):
        plain = carried_by(ended)
        fields[EARLIER_STAGE.format(number)] = json.dumps(plain.numbers)
        fields.update({EARLIER_STAGE.format(number) + name: array for name, array in plain.arrays.items()})

    def save(path: Path) -> None:
        with open(path, "wb") as file:
            np.savez_compressed(file, body=outcome.snapshot.body[living], time=outcome.snapshot.time, **fields)

    write_atomically(directory / STATE, save)
