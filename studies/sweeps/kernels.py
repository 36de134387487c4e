"""Compiles the kernels of sweeps into the cache before their runs ask for them.

``python -m studies.sweeps.kernels EXAMPLE ...`` takes examples that ship, and without one a JSON list of documents from
stdin. It needs numba, NumPy, SciPy and PyYAML alone, so that a set-up begins with it. One step of one run of each kind
compiles all, in a process of its own, as many at once as there are cores.
"""

import json
import os
import sys
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context

from studies.quantities.parameters import Plain
from studies.runs.run import Run, RunSpec
from studies.scenarios import Setting
from studies.sweeps import examples
from studies.sweeps.document import read_yaml
from studies.sweeps.sweep import Sweep


def kinds_of(runs: Iterable[Run]) -> list[Run]:
    """One run of each scenario, choices and laws of the materials: runs that agree in them share their kernels."""
    first: dict[object, Run] = {}
    for run in runs:
        named = {*run.materials, "recipe"}
        choices = [item for item in run.parameters.items() if isinstance(item[1], str) and item[0] not in named]
        laws = [(role, material.eos.kind, material.strength.kind) for role, material in run.materials.items()]
        first.setdefault((run.scenario, *sorted(choices), *sorted(laws)), run)
    return list(first.values())


def _compile(plain: RunSpec) -> None:
    from solver.simulation import simulate
    from studies.runs.stages import setting_of

    run = Run.from_json(plain)
    setting: Setting | None = setting_of(run)
    while setting is not None:
        problem = setting.problem
        outcome = simulate(replace(problem, end_time=problem.start_time + 1e-15))
        setting = run.set_up.next_stage(setting, outcome, run.materials)


def main(documents: Sequence[Mapping[str, Plain]]) -> None:
    """Compile the kernels of some sweeps, and print how many kinds there are."""
    runs = (point.run for document in documents for point in Sweep.parse(document).every_run())
    kinds = [run.as_json() for run in kinds_of(runs)]
    with ProcessPoolExecutor(min(len(kinds), os.cpu_count() or 1), mp_context=get_context("spawn")) as pool:
        print(len(list(pool.map(_compile, kinds))))


if __name__ == "__main__":
    names = sys.argv[1:]
    main([read_yaml(examples.text(name), name) for name in names] or json.load(sys.stdin))
