"""Four totals of the project, the types of its tests, and how long a start takes: ``make claims house``.

Layers, circles of imports and the spine without features are contracts of import-linter (``pyproject.toml``).
"""

import json
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from tests.claims.rows import at_most, equal
from tests.contracts.features import ROOT, features
from tests.contracts.test_way import SWEEP
from tests.service.support.serving import serving

PRODUCT = ("solver", "studies", "service", "whipple", "docs")
# Totals that no change raises: what is counted says each.
MOST_OF_PRODUCT = 63_000  # lines of Python in the product
MOST_OF_SPINE = 45_000  # lines of Python in the product without the features
MOST_OF_TESTS = 34_000  # lines of Python in tests/, but for the physics of tests/cases
MOST_WORDS = 45_000  # words of Markdown in docs/ and at the top
READY, CACHED = 1.0, 2.0  # s


def in_git(*patterns: str) -> Iterator[Path]:
    """Files that git knows and that are there."""
    listed = subprocess.run(["git", "ls-files", *patterns], cwd=ROOT, capture_output=True, text=True, check=True)
    return (ROOT / name for name in listed.stdout.splitlines() if (ROOT / name).is_file())


def lines(files: Iterator[Path]) -> int:
    return sum(len(file.read_text(encoding="utf-8").splitlines()) for file in files)


@pytest.mark.claim("house", "totals", minutes=0.1)
def test_totals__are_below_what_the_project_allows_itself(compared: Callable[..., None]) -> None:
    """The product has at most 63 000 lines, its spine 45 000, the tests 34 000, and the documentation 45 000 words."""
    product = list(in_git(*(f"{folder}/*.py" for folder in PRODUCT)))
    modules = {file: ".".join(file.relative_to(ROOT).with_suffix("").parts) for file in product}
    spine = (file for file in product if not any(feature.has(modules[file]) for feature in features().values()))
    tests = in_git("tests/*.py", ":!tests/cases")
    words = sum(len(page.read_text(encoding="utf-8").split()) for page in in_git("docs/*.md", ":(glob)*.md"))
    compared(
        at_most("lines of Python in the product", limit=MOST_OF_PRODUCT, got=lines(iter(product))),
        at_most("lines of Python in the spine", limit=MOST_OF_SPINE, got=lines(spine)),
        at_most("lines of Python in tests/ without tests/cases", limit=MOST_OF_TESTS, got=lines(tests)),
        at_most("words in docs/ and at the top", limit=MOST_WORDS, got=words),
    )


@pytest.mark.claim("house", "types", minutes=0.8)
def test_types__hold_in_tests_and_documentation_too(compared: Callable[..., None]) -> None:
    """mypy finds nothing in the product, the tests and what makes the documentation."""
    ended = subprocess.run([sys.executable, "-m", "mypy"], cwd=ROOT, capture_output=True, text=True, check=False)
    errors = ended.stdout.count(": error:")
    compared(equal("exit status of mypy, and errors that it finds", expected=(0, 0), got=(ended.returncode, errors)))


# --- how long a start takes -------------------------------------------------------------------------


@pytest.mark.claim("house", "starts", minutes=0.5)
def test_start__is_quick(tmp_path: Path, compared: Callable[..., None]) -> None:
    """The service is ready within a second, and a sweep of a run that is there published within two."""

    def swept(name: str, *options: str) -> float:
        """Seconds of ``whipple sweep`` on a document of a name, whose one run is always the same."""
        document = tmp_path / f"{name}.json"
        document.write_text(json.dumps({**SWEEP, "name": name}))
        begin = time.perf_counter()
        command = [sys.executable, "-m", "service", "sweep", str(document), "--out", str(tmp_path / "out")]
        subprocess.run([*command, *options], cwd=ROOT, check=True, capture_output=True)
        return time.perf_counter() - begin

    begin = time.perf_counter()
    with serving(tmp_path / "data") as service:
        service.wait_until_ready()
        compared(at_most("whipple serve until it is ready (s)", limit=READY, got=time.perf_counter() - begin))
    swept("first")
    compared(at_most("whipple sweep of a run that is there (s)", limit=CACHED, got=swept("again", "--overwrite")))
