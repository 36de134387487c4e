"""The end of a log names the flags that people read on the page of the run."""

import pytest

from service.pages.pages.runs import _printed
from studies.runs.results import RunResult
from studies.runs.run_log import RunLog
from tests.studies.support.fakes import measured


@pytest.mark.parametrize("of_the_run", [(), ("under_resolved",)])
def test_log__names_the_flags_of_the_page(of_the_run: tuple[str, ...]) -> None:
    hole = measured(0.0148, "error_unknown", "still_growing")
    lines: list[str] = []
    RunLog(lines.append).end(RunResult("id", "succeeded", measurements={"hole_diameter": hole}, flags=of_the_run))
    page = ", ".join(_printed("hole_diameter", hole.value, hole.uncertainty, hole.flags, {}).flags)
    assert page == "error unknown, still growing"
    assert lines[1].endswith(f"[{page}]")
    assert lines[-2:] == [
        f"flags of the run: {', '.join(of_the_run).replace('_', ' ') or 'none'}",
        f"flags of what it measured: {page}",
    ]
