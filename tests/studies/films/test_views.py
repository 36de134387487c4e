"""What pages draw of a run of a debris cloud."""

import math

import numpy as np
import pytest

from studies.films import views
from studies.films.packed import packed
from tests.studies.runs.solved import asked, solved


def test_film__of_a_run_without_one_has_the_sections_that_reports_show() -> None:
    view = views.film(asked("debris_cloud"), solved("debris_cloud") / "sections.npz")
    assert [frame.time for frame in view.frames] == sorted(frame.time for frame in view.frames)
    assert view.mirrored
    assert view.frames[-1].position[:, 1].max() > 0.0  # debris is below the plate
    assert packed(view)


def test_cloud__is_turned_about_the_axis_and_has_the_mass_of_the_bodies() -> None:
    run, folder = asked("debris_cloud"), solved("debris_cloud")
    view = views.cloud(run, folder / "state.npz")
    [points] = view.frames
    x, y, _ = points.position.T
    assert points.position.shape == (views.MOST_POINTS, 3)
    assert abs(x.mean()) < 0.02 * np.abs(x).max()
    assert np.hypot(x, y).min() >= 0.0
    assert x.std() == pytest.approx(y.std(), rel=0.02)
    share = float(view.note.partition("point of projectile is ")[2].split()[0]) * 1e-6
    diameter = float(run.parameters["projectile_diameter"] or 0.0)
    mass = math.pi / 6.0 * diameter**3 * run.materials["projectile"].density
    assert share * np.sum(points.body == 0) == pytest.approx(mass, rel=1e-3)


def test_radiograph__of_the_final_state_is_the_one_that_the_run_took_at_its_end() -> None:
    run, folder = asked("debris_cloud"), solved("debris_cloud")
    [taken], [kept] = (views.radiograph(run, folder / f"{name}.npz").frames for name in ("state", "sections"))
    assert taken.time == kept.time
    assert taken.position == pytest.approx(kept.position)
    assert taken.fields["areal_density"] == pytest.approx(kept.fields["areal_density"], rel=1e-6)  # single precision
