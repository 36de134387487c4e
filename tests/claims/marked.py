"""Claims are tests: a pytest mark, and the fixture that compares and prints each figure.

A test becomes a claim by its mark; the first line of its docstring is the sentence, or ``says`` where a parameter is::

    @pytest.mark.claim("queue", "replicas", minutes=2.0)
    def test_replicas__compute_once(compared):
        \"\"\"Two services on one store that are asked the same at once compute it once.\"\"\"
        ...
        compared(equal("runs that succeeded", expected=22, got=succeeded))

``compared`` fails the test when a row fails, and ``make claims NAME`` prints each row. A claim with ``minutes`` (of a
core, as measured once) runs by its name or that of its set alone, unless it is ``short``: then its test has a short
form, which is an ordinary test, and asks ``in_full`` for the other one. A claim without minutes is an ordinary test as
well. Several tests may have the mark of one claim, and a test the marks of several sets; ``claimed`` makes
parameters, of which some are ordinary tests too.
"""

import os
import time
from collections.abc import Callable, Collection, Generator, Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

from tests.claims.rows import Row, equal

TESTS = Path(__file__).parents[1]
ROWS = pytest.StashKey[list[Row]]()
MARKS = ("pytest.mark.claim(", "claimed(")
ALL = "all"  # in place of a name: every claim
Compared = Callable[..., None]  # what the fixture ``compared`` gives: called with rows
IN_FULL = "WHIPPLE_CLAIMS_IN_FULL"  # environment, also of the processes that a test starts


@dataclass(frozen=True)
class Marked:
    """What the mark of a test says."""

    set: str
    name: str
    minutes: float = 0.0  # 0: seconds, and part of the ordinary tests
    short: bool = False  # an ordinary test too, in its short form
    says: str = ""  # the sentence, where it is not the first line of the docstring


def in_full() -> bool:
    """Whether claims run by name: then tests that have a short form take the full one."""
    return IN_FULL in os.environ


def files() -> list[str]:
    """The test files in which a mark stands; only these are collected for a claim."""
    texts = {str(path): path.read_text(encoding="utf-8") for path in TESTS.rglob("test_*.py")}
    return sorted(path for path, text in texts.items() if any(mark in text for mark in MARKS))


def claimed(values: Iterable[Any], ordinary: Collection[Any], *claim: str, minutes: float = 0.1) -> list[Any]:
    """Parameters with the mark of a claim, set and name; those that are no ordinary tests have its minutes."""
    return [
        pytest.param(each, marks=pytest.mark.claim(*claim, minutes=0.0 if each in ordinary else minutes))
        for each in values
    ]


def marks_of(item: pytest.Item) -> list[Marked]:
    """The claims that a test is; the first one names its rows."""
    return [Marked(*mark.args, **mark.kwargs) for mark in item.iter_markers("claim")]


def sentence_of(item: pytest.Item) -> str:
    """What a claim says: ``says`` of its mark, the first line of the docstring of the test, or its name."""
    said = next((mark.says for mark in marks_of(item) if mark.says), "")
    text = getattr(getattr(item, "function", None), "__doc__", None)
    return said or (text.strip().splitlines()[0] if text else item.name)


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--claims", action="append", metavar="NAME", help="run the tests that are this claim or set")


def pytest_configure(config: pytest.Config) -> None:
    config.addinivalue_line(
        "markers", "claim(set, name, minutes=0, short=False, says=''): what the project says about itself"
    )
    if config.getoption("--claims"):
        os.environ[IN_FULL] = "1"


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Keep the claims that were named, of which each must exist; without a name, all tests but the long claims."""
    names = set(config.getoption("--claims") or ())
    there = {item: {name for mark in marks_of(item) for name in (mark.set, mark.name)} for item in items}
    if unknown := names - {""}.union(*there.values()) - {ALL}:
        sets = sorted({mark.set for item in items for mark in marks_of(item)})
        raise pytest.UsageError(
            f"no claim and no set of claims is named {', '.join(map(repr, sorted(unknown)))}; "
            f"the sets are {', '.join(sets)}, and --list names the claims"
        )

    def wanted(item: pytest.Item) -> bool:
        if names:
            return bool(there[item] & names or (there[item] and ALL in names))
        return all(mark.short or not mark.minutes for mark in marks_of(item))

    config.hook.pytest_deselected(items=[item for item in items if not wanted(item)])
    items[:] = [item for item in items if wanted(item)]


@pytest.fixture
def compared(request: pytest.FixtureRequest) -> Callable[..., None]:
    """Compare figures with what is claimed; a row that fails fails the test, after all others are compared."""
    marks, rows = marks_of(request.node), request.node.stash.setdefault(ROWS, [])
    name = marks[0].name if marks else request.node.name
    begin = time.perf_counter()

    def compare(*figures: Row) -> None:
        nonlocal begin
        for row in figures:
            now = time.perf_counter()
            rows.append(row)
            if in_full():
                with request.config.pluginmanager.getplugin("capturemanager").global_and_fixture_disabled():
                    print(f"{name} | {row} | {now - begin:.1f} s", flush=True)
            begin = now

    return compare


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item: pytest.Item) -> Generator[None, object, object]:
    """Fail a test whose rows fail, or that asked for rows and compared none."""
    outcome = yield
    if ROWS in item.stash:
        rows = item.stash[ROWS]
        assert rows, "nothing was compared"
        assert all(row.passed is not False for row in rows), "\n".join(map(str, rows))
    return outcome


@dataclass(eq=False)  # pytest keeps plugins in sets
class Judge:
    """A pytest plugin that collects the verdicts of the claims of a selection, and one for how each test ended."""

    verdicts: list[str] = field(default_factory=list)
    listed: dict[Marked, None] = field(default_factory=dict)  # in order, each once, with its sentence

    def pytest_collection_finish(self, session: pytest.Session) -> None:
        for item in session.items:
            for mark in marks_of(item):
                self.listed[Marked(mark.set, mark.name, mark.minutes, mark.short, sentence_of(item))] = None
        if not session.config.option.collectonly:
            print(f"{len(session.items)} tests", flush=True)

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(
        self, item: pytest.Item, call: pytest.CallInfo[None]
    ) -> Generator[None, pytest.TestReport, pytest.TestReport]:
        report = yield
        marks = marks_of(item)
        if marks and (call.when == "call" or not report.passed):
            ended = equal(sentence_of(item), expected="passed", got=report.outcome)
            print(f"{marks[0].name} | {ended} | {call.duration:.1f} s", flush=True)
            self.verdicts += [row.verdict for row in (*item.stash.get(ROWS, []), ended)]
        return report


def judge(names: Sequence[str], *options: str) -> tuple[pytest.ExitCode | int, Judge]:
    """Run the marked tests that a name, that of a set or ``all`` selects; pytest's status, and what was seen."""
    judged = Judge()
    named = [argument for name in names for argument in ("--claims", name)]
    plain = ["-p", __name__, "-q", "--no-header", "--tb=short", "--disable-warnings"]
    status = pytest.main([*plain, *options, *named, *files()], plugins=[judged])
    return status, judged
