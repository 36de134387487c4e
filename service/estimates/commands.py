"""The cost of a sweep, on the command line."""

from collections.abc import Iterable
from dataclasses import asdict
from typing import TYPE_CHECKING

import typer

from service.cli.commands import LOCAL, Commands
from service.cli.console import print_json, print_warnings, say
from service.cli.options import Accuracy, Json, SweepFile, document_of
from studies.quantities.display import duration

if TYPE_CHECKING:
    from studies.sweeps.cost import Cost, PresetCost

app = typer.Typer()
COMMANDS = Commands("estimates", LOCAL, app)


@app.command()
def estimate(file: SweepFile, accuracy: Accuracy = None, as_json: Json = False) -> None:
    """Estimate the cost of a sweep, as it is and at each accuracy. Nothing is computed."""
    from service.settings import Settings
    from studies.sweeps.cost import cost_of, presets_of
    from studies.sweeps.reading import SweepLimits
    from studies.sweeps.sweep import Sweep

    limit = Settings().max_runs
    sweep = Sweep.parse(document_of(file, accuracy=accuracy), SweepLimits(max_runs=limit))
    cost, presets = cost_of(sweep), list(presets_of(sweep, limit))
    if as_json:
        print_json({"name": sweep.name, **asdict(cost), "presets": [asdict(preset) for preset in presets]})
    else:
        _print_cost(sweep.name, cost, presets)
    print_warnings(sweep)


def _print_cost(name: str, cost: "Cost", presets: "Iterable[PresetCost]") -> None:
    """The cost of a sweep, as it is and at each accuracy."""
    from studies.sweeps.accuracy import in_percent

    say(f"{name}: {_cost(cost)}")
    for preset in presets:
        text = f"not available: {preset.reason}"
        if preset.cost and preset.cells:
            fewest, most = preset.cells
            cells = f"{fewest:g} cells" if fewest == most else f"{fewest:g} to {most:g} cells"
            text = f"{cells} across the diameter: {_cost(preset.cost)}"
        say(f"  accuracy: {in_percent(preset.error)} ({preset.name})".ljust(28) + text)


def _cost(cost: "Cost") -> str:
    time, size = duration(cost.core_seconds), cost.bytes / 1e6
    memory = f"{cost.memory / 1e6:.0f} MB of memory a run"
    return f"{cost.runs} runs, about {time} of one core, {size:.0f} MB of files, {memory}"
