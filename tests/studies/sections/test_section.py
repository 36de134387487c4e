"""The sections of a run: its particles in the plane through the axis, kept in few bytes."""

from pathlib import Path

import numpy as np
import pytest

from solver.errors import Interrupted
from studies.runs.execution import execute
from studies.runs.remeasure import load_state
from studies.runs.results import RunControl
from studies.runs.run import Run
from studies.sections import section
from studies.sections.section import END, Sections, read_sections
from tests.samples import needs
from tests.studies.runs.solved import asked, solved

QUANTISED = 1.0 / section.STEPS  # of the box of all positions
HALF_PRECISION = 2.0**-10


def end_of(folder: Path) -> tuple[Sections, section.Section]:
    sections = read_sections(folder / "sections.npz")
    end = sections.at(END)
    assert end
    return sections, end


@pytest.mark.parametrize("scenario", ["thin_plate", pytest.param("taylor_bar", marks=needs("taylor_bar"))])
def test_section__at_the_end_is_the_final_state(scenario: str) -> None:
    folder = solved(scenario)
    sections, end = end_of(folder)
    state = load_state(folder / "state.npz")
    order = np.argsort(state.particles.number)
    position = state.particles.position[order][:, :2]  # across and along, of bodies of revolution
    box = np.ptp(position, axis=0).max()
    assert end.time == state.time
    assert sections.mirrored
    np.testing.assert_allclose(end.position, position, atol=QUANTISED * box)
    np.testing.assert_array_equal(end.body, state.body[order])
    for name in ("plastic_strain", "temperature", "pressure", "density"):
        expected = getattr(state.particles, name)[order]
        unit = section.FIELDS[name]
        np.testing.assert_allclose(end.fields[name], expected, rtol=HALF_PRECISION, atol=1e-7 * unit)
    speed = np.linalg.norm(state.particles.velocity[order], axis=1)
    np.testing.assert_allclose(end.fields["speed"], speed, rtol=HALF_PRECISION, atol=1e-6)


def test_sections__of_a_resumed_run_are_those_of_one_that_never_stopped(tmp_path: Path) -> None:
    run, left = asked("thin_plate", end_time=12e-6), tmp_path / "left"
    whole = sections_of(run, tmp_path / "whole")
    checkpoint, states = tmp_path / "checkpoint.npz", 0

    def must_stop() -> bool:
        return states > 8  # between the two moments

    def count(_: object) -> None:
        nonlocal states
        states += 1

    with pytest.raises(Interrupted):
        execute(run, left, RunControl(progress=count, must_stop=must_stop), checkpoint=checkpoint)
    resumed = sections_of(run, left, checkpoint)
    assert [state.moment for state in resumed.states] == [0, 1, END]
    for before, after in zip(whole.states, resumed.states, strict=True):
        assert before.time == after.time
        # What was read from the file of the checkpoint was stored twice.
        np.testing.assert_allclose(after.position, before.position, atol=1e-6)


def sections_of(run: Run, folder: Path, checkpoint: Path | None = None) -> Sections:
    execute(run, folder, threads=1, checkpoint=checkpoint)
    return read_sections(folder / "sections.npz")
