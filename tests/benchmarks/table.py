"""Writes the figures of a file into docs/speed.md: ``python -m tests.benchmarks.table FILE``.

The file is that of ``make bench JSON=FILE``; what it does not hold is left out.
"""

import json
import sys
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

from tests.benchmarks.figures import STAGED
from tests.benchmarks.measure import BARS, FAMILIES
from tests.contracts.features import ROOT

PAGE = ROOT / "docs" / "speed.md"
BEGIN, END = "<!-- figures: begin -->\n", "<!-- figures: end -->\n"
SIZES = "12k", "117k", "1m"

OTHERS = {
    "3d_linear_two_threads_117k": "two threads at 117 k in 3-D linear, of the throughput of two runs of one thread",
    "3d_sph_two_threads_117k": "the same by smoothed particles",
    "axisymmetric_quadrilaterals_two_threads_117k": "the same in quadrilaterals of revolution",
    "3d_hexahedra_two_threads_117k": "the same in hexahedra",
    "python_us_per_step": "Python of a step, us",
    "axisymmetric_default_12k_large_box": "a box of 20 nodes per particle, axisymmetric default, times",
    "3d_linear_117k_large_box": "the same in 3-D linear, times",
    "crater_observation_ms": "an observation of a crater, ms",
    "3d_linear_1m_bytes_per_particle": "bytes per particle at 1 M, 3-D linear",
    "axisymmetric_default_1m_bytes_per_particle": "the same, axisymmetric default",
    "compile_kind_s": "compiling a kind of kernels, the dearest of three, core-s",
    "axisymmetric_default_first_step_s": "a process to its first step, core-s",
    "demo_core_s": "the demo, core-s",
    "demo_compile_core_s": "compiling its kernels before, core-s",
    "demo_wall_s": "both, wall, s",
    "demo_steps": "steps of its runs",
    "demo_particle_steps": "particle-steps of its runs",
    "demo_share_after_settling": "share of a run's time after it settled (0.5 %), mean",
    "sweep_core_s": "six speeds at 16, 32 and 64 cells a diameter, core-s",
    "sweep_former_core_s": "the same by the former tree, core-s",
    "sweep_former_runs": "of its 18 runs, measured",
    "sweep_share_of_former": "share of these, through the reference kernel",
    "thesis_particle_steps": "the thesis' thick plate, particle-steps",
    "thesis_ns": "processor time of one of its first steps, ns per particle-step",
    "thesis_mpm3d_f90_ns": "the same in MPM3D-F90, ns",
    "thesis_times_mpm3d_f90": "times as fast, in turns",
    "thesis_extrapolated_wall_s": "its whole run, extrapolated from the wall of the first steps, s",
    "thesis_mpm3d_f90_extrapolated_wall_s": "the same in MPM3D-F90, s",
}


def main() -> None:
    """Put the tables between the marks of the page."""
    figures = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
    text = PAGE.read_text(encoding="utf-8")
    before, rest = text.split(BEGIN)
    _, after = rest.split(END)
    tables = "".join(f"{line}\n" for line in page(figures))
    PAGE.write_text(f"{before}{BEGIN}{tables}{END}{after}", encoding="utf-8")


def page(figures: Mapping[str, Any]) -> Iterator[str]:
    """The lines of all tables."""
    about = "{date}, {processor}, {cores} cores, load {load} at the start, Python {python}."
    yield about.format_map(figures)
    yield ""
    yield "| ns per step of a particle or element (times the reference kernel) | 12 k | 117 k | 1 M | speedup |"
    yield "|---|---|---|---|---|"
    for family in (*FAMILIES, *BARS):
        for threads, tag in ((1, ""), (2, "_2_threads")):
            names = [f"{family}_{size}{tag}" for size in SIZES]
            cells = [_cost(figures, name) for name in names]
            speedup = _figure(figures, f"{family}_speedup", "{:.1f}".format) if threads == 1 else ""
            if any(cells):
                yield _row(f"{family}, {threads} thread{'s' * (threads > 1)}", *cells, speedup)
            rates = [_figure(figures, f"{name}_elements_per_core_second") for name in names]
            if any(rates):
                yield _row("elements a second of a core", *rates, "")
    yield _row("a number of the reference kernel", _figure(figures, "reference_ns"), "", "", "")
    yield ""
    yield from _stages(figures)
    yield "| | |"
    yield "|---|---|"
    for name, meaning in OTHERS.items():
        if name in figures:
            yield _row(meaning, _figure(figures, name))


def _stages(figures: Mapping[str, Any]) -> Iterator[str]:
    first = f"{STAGED[0]}_stage_"
    stages = [name.removeprefix(first) for name in figures if name.startswith(first)]
    if stages:
        yield _row("stage, ns per particle-step", *STAGED)
        yield "|---|---|---|---|"
        for stage in stages:
            cells = [_figure(figures, f"{name}_stage_{stage}", "{:.1f}".format) for name in STAGED]
            yield _row(stage.removesuffix("_ns"), *cells)
        yield ""


def _cost(figures: Mapping[str, Any], name: str) -> str:
    ratio = _figure(figures, f"{name}_per_reference", "{:.1f}".format)
    return f"{_figure(figures, f'{name}_ns', '{:.0f}'.format)} ({ratio})" if ratio else ""


def _figure(figures: Mapping[str, Any], name: str, form: Callable[[float], str] = "{:.4g}".format) -> str:
    return form(figures[name]) if name in figures else ""


def _row(*cells: str) -> str:
    return f"| {' | '.join(cells)} |"


if __name__ == "__main__":
    main()
