"""The cost of a sweep, on the command line."""

import sys
from dataclasses import asdict

import typer

from service.cli.commands import LOCAL, Commands
from service.cli.console import print_json, say
from service.cli.options import Accuracy, Json, SweepFile

app = typer.Typer()
COMMANDS = Commands("estimates", LOCAL, app)


@app.command()
def estimate(file: SweepFile, accuracy: Accuracy = None, as_json: Json = False) -> None:
    """Estimate the cost of a sweep, as it is and at each accuracy. Nothing is computed."""
    from service.estimates.estimate import estimate as estimated

    found = estimated(file, accuracy=accuracy)
    if as_json:
        presets = [asdict(preset) for preset in found.presets]
        print_json({"name": found.name, **asdict(found.cost), "presets": presets})
    else:
        say(str(found))
    for warning in found.warnings:
        say(f"whipple: warning: {warning}", file=sys.stderr)
