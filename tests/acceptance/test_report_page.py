"""The report in a real browser, from disk: the figures are drawn, and nothing is asked of the network."""

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from studies.reports.publish import publish_sweep
from tests.studies.support import fakes

CHROMIUM = os.environ.get("WHIPPLE_CHROMIUM") or shutil.which("chromium")
FLAGS = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--enable-logging=stderr",
    "--virtual-time-budget=20000",
    # Whatever the page may ask for is answered by nobody.
    "--host-resolver-rules=MAP * ~NOTFOUND",
)
PATIENCE = 120  # s: a cold browser on a busy machine

pytestmark = [
    pytest.mark.browser,
    pytest.mark.skipif(not CHROMIUM, reason="no Chromium: name one in WHIPPLE_CHROMIUM"),
]


@pytest.fixture(scope="module")
def opened(tmp_path_factory: pytest.TempPathFactory) -> tuple[str, str]:
    """The page after its scripts have run, and the log of the browser."""
    folder = tmp_path_factory.mktemp("report")
    sweep = fakes.holes()
    catalogue = fakes.catalogue(observations=fakes.SHOTS)
    files = publish_sweep(sweep, fakes.with_trouble(sweep), folder, catalogue)
    page = Path(files["report.html"]).as_uri()
    assert CHROMIUM
    profile = f"--user-data-dir={tmp_path_factory.mktemp('profile')}"
    answer = subprocess.run(
        [CHROMIUM, *FLAGS, profile, "--dump-dom", page],
        capture_output=True,
        text=True,
        check=True,
        timeout=PATIENCE,
    )
    return answer.stdout, answer.stderr


def test_page__draws_every_figure(opened: tuple[str, str]) -> None:
    page, _ = opened
    places = re.findall(r"<div [^>]*data-plot=[^>]*>", page)
    assert places
    assert all("js-plotly-plot" in place for place in places)
    assert len(re.findall(r'class="[^"]*svg-container', page)) == len(places)


def test_page__shows_every_series_in_the_legend(opened: tuple[str, str]) -> None:
    page, _ = opened
    legend = set(re.findall(r'class="legendtext"[^>]*>([^<]+)<', page))
    laws = {"thesis 1-3, aluminium", "thesis 1-4", "thesis 1-5, all constants"}
    assert {"simulation", "observed", "run without a value", *laws} <= legend


def test_page__runs_without_a_message_on_the_console(opened: tuple[str, str]) -> None:
    _, log = opened
    assert [line for line in log.splitlines() if "CONSOLE" in line] == []
