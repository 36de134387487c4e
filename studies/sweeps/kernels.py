"""Compiles the kernels of sweeps into the cache before their runs ask for them.

``python -m studies.sweeps.kernels EXAMPLE ...`` takes examples that ship, and without one a JSON list of documents from
stdin. It needs numba, NumPy, SciPy and PyYAML alone, so that a set-up begins with it.

Which kernels a run needs is decided by its geometry, its numerical choices and the laws of its materials; runs that
agree in these are of one kind, and one step of one of them compiles all. Each kind is compiled in a process of its own,
as many at once as there are cores.
"""

import json
import os
import sys
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context
from typing import Any

from studies.runs.run import Run, RunSpec
from studies.scenarios import Setting, load
from studies.sweeps import examples
from studies.sweeps.document import read_yaml
from studies.sweeps.sweep import Sweep

KernelKind = tuple[Any, ...]


def kinds_of(runs: Iterable[Run]) -> list[Run]:
    """One run of each kind."""
    first: dict[KernelKind, Run] = {}
    for run in runs:
        first.setdefault(_kind(run), run)
    return list(first.values())


def compile_kernels(runs: Iterable[Run]) -> int:
    """Compile what runs need; returns how many kinds they are of."""
    kinds = [run.as_json() for run in kinds_of(runs)]
    at_once = min(len(kinds), os.cpu_count() or 1)
    if at_once <= 1:
        for kind in kinds:
            _compile(kind)
        return len(kinds)
    with ProcessPoolExecutor(at_once, mp_context=get_context("spawn")) as pool:
        list(pool.map(_compile, kinds))
    return len(kinds)


def _compile(run: RunSpec) -> None:
    from solver.simulation import simulate
    from studies.runs.run import materials_of
    from studies.runs.stages import setting_of

    resolved = Run.from_json(run)
    parameters = load(resolved.scenario).record(resolved.parameters)
    setting: Setting | None = setting_of(resolved)
    while setting is not None:
        problem = setting.problem
        outcome = simulate(replace(problem, end_time=problem.start_time + 1e-15))
        setting = parameters.next_stage(setting, outcome, materials_of(resolved))


def _kind(run: Run) -> KernelKind:
    """Scenario, choices and laws of the materials: runs that agree in them share their kernels."""
    choices = {
        name: value
        for name, value in run.parameters.items()
        if isinstance(value, str) and name not in (*run.materials, "recipe")
    }
    laws = {
        (role, section): part["kind"]
        for role, plain in run.materials.items()
        for section, part in plain.items()
        if isinstance(part, Mapping) and "kind" in part
    }
    return run.scenario, tuple(sorted(choices.items())), tuple(sorted(laws.items()))


def main(documents: Sequence[Mapping[str, Any]]) -> None:
    """Compile the kernels of some sweeps, and print how many kinds there are."""
    runs = [point.run for document in documents for point in Sweep.parse(document).every_run()]
    print(compile_kernels(runs))


if __name__ == "__main__":
    names = sys.argv[1:]
    main([read_yaml(examples.text(name), name) for name in names] or json.load(sys.stdin))
