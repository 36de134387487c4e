"""What docs/service.md says is what there is: settings, commands and states; the build of the site checks links."""

import re
from pathlib import Path

import pytest
import typer.main

from service.cli.main import app
from service.settings import Settings

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "service.md").read_text(encoding="utf-8")
README = (ROOT / "README.md").read_text(encoding="utf-8")
COMMAND = re.compile(r"\bwhipple ([a-z][a-z-]*)")
NO_COMMANDS = {"has", "does", "refuses"}  # of sentences about whipple itself


def commands() -> set[str]:
    """Every subcommand, groups included."""
    group = typer.main.get_command(app)
    return set(group.commands)  # type: ignore[attr-defined]


def test_settings__are_all_there_with_their_defaults() -> None:
    rows = [line for line in PAGE.splitlines() if line.startswith("| `WHIPPLE_")]
    for name in Settings.model_fields:
        assert any(f"`WHIPPLE_{name.upper()}`" in row for row in rows), name
    messages = set(re.findall(r"`WHIPPLE_([A-Z_]+)`", "\n".join(rows)))
    assert {item.lower() for item in messages} - set(Settings.model_fields) == {"kernel_cache"}
    for name in ("host", "port", "max_runs", "poll_seconds", "leave_seconds", "retire_seconds"):
        [row] = [row for row in rows if f"`WHIPPLE_{name.upper()}`" in row]
        default = Settings.model_fields[name].get_default()
        assert f"`{default:g}`" in row or f"`{default}`" in row if name != "host" else default in row


@pytest.mark.parametrize("text", [PAGE, README], ids=["service.md", "README.md"])
def test_commands__that_are_named_are_there(text: str) -> None:
    blocks = re.findall(r"```sh\n(.*?)```|`(whipple [^`]*)`", text, re.DOTALL)
    named = {word for pair in blocks for part in pair for word in COMMAND.findall(part)}
    assert named <= commands() | NO_COMMANDS, named - commands()


def test_commands__of_a_service_are_all_told_of() -> None:
    local = {"demo", "sweep", "continue", "estimate", "validate", "deck", "calibrate"}
    local |= {"export", "plot", "fit", "surrogate"}
    for name in commands() - local - {"list", "laws", "shots", "schema"}:
        assert f"whipple {name}" in PAGE, name
