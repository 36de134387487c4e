"""docs/restart.md: the drills that it names exist."""

import re

from tests.claims.marked import TESTS
from tests.contracts.features import ROOT


def test_page__names_drills_that_exist() -> None:
    page = (ROOT / "docs" / "restart.md").read_text(encoding="utf-8")
    tests = "".join(file.read_text(encoding="utf-8") for file in TESTS.rglob("test_*.py"))
    named = re.findall(r"`(test_\w+)`", page) + re.findall(r"`make claims ([a-z-]+)`", page)
    assert len(named) > 15
    assert [name for name in named if f"def {name}(" not in tests and f'", "{name}"' not in tests] == []
