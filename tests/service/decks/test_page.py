"""docs/decks.md tells of every material and of what is refused; its commands run as those of every page do."""

from pathlib import Path

import pytest

from studies.decks.macros import KINDS, REFUSED

TEXT = (Path(__file__).parents[3] / "docs" / "decks.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", [*KINDS, *REFUSED])
def test_page__tells_of_every_material_and_refusal(name: str) -> None:
    assert f"`{name}`" in TEXT
