"""Claims that are tests: a pytest marker, and the fixture that compares and prints each figure.

A test becomes a claim by its mark; the first line of its docstring is the sentence::

    @pytest.mark.claim("queue", "kill-any-part", minutes=2.0)
    def test_kill__loses_and_doubles_nothing(compared):
        \"\"\"A part that is killed at any moment loses no run and doubles none.\"\"\"
        ...
        compared(equal("runs that succeeded", expected=22, got=succeeded))

``compared`` fails the test when the row fails, and ``make claims NAME`` prints each row. A claim with ``minutes`` (of a
core, as measured once) runs by its name or that of its set alone; one without is an ordinary test as well.
"""

import re
import time
from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import pytest

from studies.verification import Verified
from tests.rows import Row, equal

TESTS = Path(__file__).parents[1]
ROWS = pytest.StashKey[list[Verified]]()
MARK = "pytest.mark.claim("


@dataclass(frozen=True)
class Marked:
    """What the mark of a test says."""

    set: str
    name: str
    minutes: float = 0.0  # 0: seconds, and part of the ordinary tests


def files() -> list[str]:
    """The test files in which a mark stands; only these are collected for a claim."""
    return sorted(str(path) for path in TESTS.rglob("test_*.py") if MARK in path.read_text(encoding="utf-8"))


def known() -> dict[str, set[str]]:
    """The names of marked claims by their set, as the files write them."""
    names: dict[str, set[str]] = {}
    for path in files():
        for set_name, name in re.findall(re.escape(MARK) + r'\s*"([^"]+)",\s*"([^"]+)"', Path(path).read_text("utf-8")):
            names.setdefault(set_name, set()).add(name)
    return names


def mark_of(item: pytest.Item) -> Marked | None:
    """The claim that a test is, or None."""
    mark = item.get_closest_marker("claim")
    return Marked(*mark.args, **mark.kwargs) if mark else None


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--claims", action="append", metavar="NAME", help="run the tests that are this claim or set")


def pytest_configure(config: pytest.Config) -> None:
    config.addinivalue_line("markers", "claim(set, name, minutes=0): what the project says about itself")


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Keep the claims that were named; without a name, all tests but the long claims."""
    names = config.getoption("--claims")

    def wanted(item: pytest.Item) -> bool:
        mark = mark_of(item)
        if names is None:
            return mark is None or not mark.minutes
        return mark is not None and bool({mark.set, mark.name} & set(names))

    config.hook.pytest_deselected(items=[item for item in items if not wanted(item)])
    items[:] = [item for item in items if wanted(item)]


@pytest.fixture
def compared(request: pytest.FixtureRequest) -> Callable[[Row], None]:
    """Compare a figure with what is claimed; a row that fails fails the test, after all others are compared."""
    mark, rows = mark_of(request.node), request.node.stash.setdefault(ROWS, [])
    name = mark.name if mark else request.node.name
    begin = time.perf_counter()

    def compare(row: Row) -> None:
        nonlocal begin
        now = time.perf_counter()
        rows.append(Verified(name, row, now - begin))
        if request.config.getoption("--claims"):
            with request.config.pluginmanager.getplugin("capturemanager").global_and_fixture_disabled():
                print(f"{name} | {row} | {now - begin:.1f} s", flush=True)
        begin = now

    return compare


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item: pytest.Item) -> Generator[None, object, object]:
    """Fail a test whose rows fail, or that asked for rows and compared none."""
    outcome = yield
    if ROWS in item.stash:
        rows = [each.row for each in item.stash[ROWS]]
        assert rows, "nothing was compared"
        assert all(row.passed is not False for row in rows), "\n".join(map(str, rows))
    return outcome


@dataclass(eq=False)  # pytest keeps plugins in sets
class Judge:
    """A pytest plugin that collects the rows of the claims of a selection, and one for how each test ended."""

    rows: list[dict[str, object]] = field(default_factory=list)

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(
        self, item: pytest.Item, call: pytest.CallInfo[None]
    ) -> Generator[None, pytest.TestReport, pytest.TestReport]:
        report = yield
        mark = mark_of(item)
        if mark and (call.when == "call" or not report.passed):
            ended = equal(_sentence(item), expected="passed", got=report.outcome)
            print(f"{mark.name} | {ended} | {call.duration:.1f} s", flush=True)
            compared = [*item.stash.get(ROWS, []), Verified(mark.name, ended, call.duration)]
            self.rows += [{"set": mark.set, **each.as_json()} for each in compared]
        return report


def _sentence(item: pytest.Item) -> str:
    """The first line of the docstring of a test, else its name."""
    text = getattr(getattr(item, "function", None), "__doc__", None)
    return text.strip().splitlines()[0] if text else item.name


def judge(names: Sequence[str]) -> list[dict[str, object]]:
    """The rows of the marked tests that a name or the name of a set selects, as plain objects."""
    judged = Judge()
    options = [argument for name in names for argument in ("--claims", name)]
    status = pytest.main(["-q", "--no-header", "--tb=short", *options, *files()], plugins=[judged])
    if status not in (pytest.ExitCode.OK, pytest.ExitCode.TESTS_FAILED):
        raise RuntimeError(f"pytest ended with {status!r}")
    return judged.rows
