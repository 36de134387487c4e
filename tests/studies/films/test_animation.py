"""The film of a run as a moving picture: every frame, one scale, and a cure where a program is missing."""

import sys
from pathlib import Path

import numpy as np
import pytest
from matplotlib import rcParams
from PIL import Image, ImageSequence

from studies.films.film_dataset import open_film
from studies.runs.execution import execute
from tests.service.support.command import run
from tests.studies.runs.solved import asked


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("run")
    execute(asked("thin_plate", end_time=1e-6), folder, threads=1, film=True)
    return folder


@pytest.mark.claim("pages", "gif", minutes=0.1)
def test_gif__has_every_frame_of_the_film(folder: Path, tmp_path: Path) -> None:
    """The moving picture of a run has every frame of its film."""
    assert run("export", folder, "--movie", tmp_path / "film.gif", "--field", "pressure", "--fps", 20) == 0
    with Image.open(tmp_path / "film.gif") as film:
        assert film.info["duration"] == 50  # ms
        frames = [np.asarray(frame.convert("RGB")) for frame in ImageSequence.Iterator(film)]
    assert len(frames) == open_film(folder).sizes["time"]
    assert (frames[0] != frames[-1]).any()
    assert [file.name for file in tmp_path.iterdir()] == ["film.gif"]


@pytest.mark.claim("pages", "mp4", minutes=0.1)
def test_mp4__needs_ffmpeg_or_the_library_that_brings_it(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """With the library the film of a run is an MP4; without both the error names the extra."""
    monkeypatch.setenv("PATH", str(tmp_path))  # without ffmpeg
    monkeypatch.setitem(rcParams, "animation.ffmpeg_path", "ffmpeg")
    assert run("export", folder, "--movie", tmp_path / "film.mp4") == 0
    assert (tmp_path / "film.mp4").read_bytes()[4:8] == b"ftyp"
    monkeypatch.setitem(rcParams, "animation.ffmpeg_path", "ffmpeg")
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    assert run("export", folder, "--movie", tmp_path / "other.mp4") == 1
    assert "whipple[video]" in capsys.readouterr().err
    assert [file.name for file in tmp_path.iterdir()] == ["film.mp4"]
