"""The subcommands of ``whipple``: each module here offers ``COMMANDS``.

To add one: a function in one of these with ``@app.command()``; heavy modules are imported inside of it. A feature
offers its own through the entry-point group ``whipple.service.cli.commands``.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from typer import Typer

# Titles of the panels in which the help lists commands, in its order.
LOCAL = "On this machine, without a service"
OUT_OF_A_CUBE = "Out of a cube"
SHIPPED = "What ships"
SHOTS = "Measured shots"
SERVICE = "The service, and its maintenance"
REQUESTS = "Requests to a service"
PANELS = (LOCAL, OUT_OF_A_CUBE, SHIPPED, SHOTS, REQUESTS, SERVICE)


@dataclass(frozen=True)
class Commands:
    """Subcommands that stand together in the help."""

    name: str
    panel: str  # one of PANELS
    app: Typer
    place: int = 0  # in the panel: smaller is further up
    demo: Callable[[Path], None] | None = None  # what `whipple demo` does first, with its folder
