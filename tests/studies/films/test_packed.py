"""Packed views: what a page draws is what a run has, in bounded bytes."""

import json
import math
from typing import Any

import numpy as np
import pytest

from studies.films import views
from studies.films.packed import LEVELS, MOST_BYTES, MOST_FRAMES, STEPS, UNKNOWN, FrameOfPoints, View, packed
from studies.runs.remeasure import load_state
from tests.samples import needs
from tests.studies.runs.solved import asked, solved


def unpacked(content: bytes) -> tuple[dict[str, Any], np.ndarray, np.ndarray, np.ndarray]:
    """The text of a view, positions (components, n) in m, bodies (n,) and levels (fields, n)."""
    length = int.from_bytes(content[:4], "little")
    text = json.loads(content[4 : 4 + length])
    components, count, place = len(text["low"]), sum(text["counts"]), 4 + length
    steps = np.frombuffer(content, "<u2", components * count, place).reshape(components, count)
    low, high = (np.array(text[end])[:, None] for end in ("low", "high"))
    rest = np.frombuffer(content, np.uint8, offset=place + 2 * components * count).reshape(-1, count)
    return text, low + steps / STEPS * (high - low), rest[0], rest[1:]


def view_of(count: int, frames: int = 1, note: str = "") -> View:
    random = np.random.default_rng(1)
    points = [
        FrameOfPoints(
            time=1e-6 * number,
            position=random.random((count, 2)),
            body=np.arange(count) % 2,
            fields={"speed": random.random(count) * 7e3, "pressure": np.full(count, np.nan)},
        )
        for number in range(frames)
    ]
    return View(("projectile", "target"), (1e-3, 1e-3), mirrored=True, frames=tuple(points), note=note)


def test_packed__is_what_went_in() -> None:
    view = view_of(500, frames=3)
    text, position, body, levels = unpacked(packed(view))
    assert (text["counts"], text["times"]) == ([500] * 3, [0.0, 1e-6, 2e-6])
    assert position == pytest.approx(np.concatenate([frame.position for frame in view.frames]).T, abs=1.0 / STEPS)
    assert body.tolist() == [0, 1] * 750
    speed, pressure = text["fields"]
    assert (speed["unit"], pressure["unit"]) == ("km/s", "GPa")
    shown = (speed["low"] + levels[0] / LEVELS * (speed["high"] - speed["low"])) * 1e3
    asked_for = np.concatenate([frame.fields["speed"] for frame in view.frames])
    inside = (asked_for > speed["low"] * 1e3) & (asked_for < speed["high"] * 1e3)
    assert shown[inside] == pytest.approx(asked_for[inside], abs=7e3 / LEVELS)
    assert inside.mean() > 0.98
    ends = np.array([speed["low"], speed["high"]]) * 1e3
    below, above = (asked_for < ends[0] * (1 - 1e-12)).sum(), (asked_for > ends[1] * (1 + 1e-12)).sum()
    assert f"outer 0.5 % of values: of 1500, {below} lie below and {above} above" in speed["beyond"]
    assert pressure["beyond"] == ""
    assert (levels[1] == UNKNOWN).all()


@pytest.mark.parametrize(("count", "frames"), [(2_000_000, 1), (20_000, 2 * MOST_FRAMES)])
def test_packed__of_many_points_is_thinned_and_says_so(count: int, frames: int) -> None:
    content = packed(view_of(count, frames, note="Whole."))
    text, *_ = unpacked(content)
    assert len(content) < MOST_BYTES + 10_000
    assert len(text["times"]) == min(frames, MOST_FRAMES)
    assert text["times"][-1] == 1e-6 * (frames - 1)
    stride = math.ceil(count / text["counts"][0])
    assert f"One of {stride} particles" in text["note"]
    assert text["note"].startswith("Whole.")
    assert text["width"][0] == pytest.approx(1e-3 * math.sqrt(stride))


@pytest.mark.parametrize(
    ("scenario", "file"),
    [("thin_plate", "sections.npz"), pytest.param("taylor_bar", "state.npz", marks=needs("taylor_bar"))],
)
def test_radiograph__of_a_run_without_one_is_a_note(scenario: str, file: str) -> None:
    view = views.radiograph(asked(scenario), solved(scenario) / file)
    content = packed(view)
    assert json.loads(content[4:]) == {"note": view.note, "times": []}
    assert f"run of {scenario} has no radiograph" in view.note


def test_radiograph__of_a_plate_without_debris_off_the_grid_has_its_whole_mass() -> None:
    run, folder = asked("thin_plate"), solved("thin_plate")
    view = views.radiograph(run, folder / "state.npz")
    state = load_state(folder / "state.npz")
    assert not state.departed.mass.size
    [points] = view.frames
    shown = 2.0 * points.fields["areal_density"].sum() * view.width[0] ** 2
    assert shown == pytest.approx(2.0 * math.pi * state.particles.mass.sum(), rel=1e-12)
