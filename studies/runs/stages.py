"""The stages of a run, one after another: what one left behind, stored and read again, from which the next follows."""

import json
from collections.abc import Sequence
from dataclasses import asdict, replace
from typing import Any

from solver.audit import Audit, Books
from solver.checkpoints import Carried
from solver.simulation import Counters, Outcome
from solver.state import Departed, Particles, Snapshot
from studies import scenarios
from studies.runs.run import Run, materials_of
from studies.scenarios import Setting

EARLIER_STAGE = "stage_{}_"  # in a stored final state, before the names of the arrays of an earlier stage


def setting_of(run: Run, ended: Sequence[Outcome] = ()) -> Setting:
    """The problem of a run after some stages have ended, with the sizes that its observer reads."""
    parameters, materials = scenarios.load(run.scenario).record(run.parameters), materials_of(run)
    setting = parameters.build(materials)
    for outcome in ended:
        following = parameters.next_stage(setting, outcome, materials)
        assert following is not None
        setting = following
    return setting


def carried_by(outcome: Outcome, observed: str = "") -> Carried:
    """The end of a stage as plain numbers and arrays, with the text of its observer."""
    snapshot, (books, arrays) = outcome.snapshot, outcome.books.plain()
    arrays["body"] = snapshot.body
    arrays |= {"particles_" + name: array for name, array in snapshot.particles._asdict().items()}
    arrays |= {"departed_" + name: array for name, array in snapshot.departed._asdict().items()}
    if snapshot.remembered is not None:
        arrays["remembered"] = snapshot.remembered
    numbers = {
        "time": snapshot.time,
        "step": snapshot.step,
        "waiting": snapshot.waiting,
        "stop": outcome.stop,
        "history": [asdict(audit) for audit in outcome.history],
        "counters": asdict(outcome.counters),
        "smallest_step": outcome.smallest_step,
        "particle_steps": outcome.particle_steps,
        "books": books,
        "observed": observed,
    }
    return Carried(numbers, arrays)


def outcome_of(carried: Carried) -> Outcome:
    """The end of a stage that ``carried_by`` made plain."""
    numbers, arrays = dict(carried.numbers), carried.arrays
    particles = Particles(*(arrays["particles_" + name] for name in Particles._fields))
    departed = Departed(*(arrays["departed_" + name] for name in Departed._fields))
    snapshot = Snapshot(
        numbers["time"],
        numbers["step"],
        particles,
        arrays["body"],
        departed,
        waiting=numbers["waiting"],
        remembered=arrays.get("remembered"),
    )
    history = tuple(Audit.from_plain(**audit) for audit in numbers["history"])
    return Outcome(
        snapshot=snapshot,
        stop=numbers["stop"],
        audit=history[-1],
        history=history,
        counters=Counters(**numbers["counters"]),
        smallest_step=numbers["smallest_step"],
        particle_steps=numbers["particle_steps"],
        books=Books.from_plain(numbers["books"], arrays),
    )


def earlier_stages(saved: Any) -> list[Outcome]:
    """The ends of the earlier stages in a stored final state (``numpy.load``)."""
    outcomes: list[Outcome] = []
    while (prefix := EARLIER_STAGE.format(len(outcomes) + 1)) in saved:
        arrays = {name.removeprefix(prefix): saved[name] for name in saved if name.startswith(prefix)}
        outcomes.append(outcome_of(Carried(json.loads(str(arrays.pop(""))), arrays)))
    return outcomes


def together(outcomes: Sequence[Outcome]) -> Outcome:
    """The outcome of a whole run: the end of its last stage, with the counts and histories of all."""
    counters = [asdict(outcome.counters) for outcome in outcomes]
    return replace(
        outcomes[-1],
        snapshot=outcomes[-1].snapshot._replace(step=sum(outcome.snapshot.step for outcome in outcomes)),
        history=tuple(audit for outcome in outcomes for audit in outcome.history),
        counters=Counters(**{name: sum(each[name] for each in counters) for name in counters[0]}),
        smallest_step=min(outcome.smallest_step for outcome in outcomes),
        particle_steps=sum(outcome.particle_steps for outcome in outcomes),
    )
