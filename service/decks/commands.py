"""Decks of MPM3D: what one says, and the sweep that computes it."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Literal

import typer

from service.cli.commands import LOCAL, Commands
from service.cli.commands.computing import compute
from service.cli.console import print_json, print_table
from service.cli.options import Json, Threads, folder_of
from studies.decks.deck import Deck
from studies.decks.problem import fixed_step
from studies.decks.reader import MOST_BYTES, read_deck, read_file_text
from studies.quantities.findings import refusal
from studies.quantities.parameters import Plain
from studies.sweeps.document import no_such_file, yaml_of

app = typer.Typer()
COMMANDS = Commands("decks", LOCAL, app, place=2)

FACES = ("free", "fixed", "symmetric")


@app.command()
def deck(
    file: Annotated[Path, typer.Argument(metavar="FILE.mpm", help="An input file of MPM3D.")],
    units: Annotated[Literal["deck", "mm-g-ms", "SI"], typer.Option(help="Units; by default those it names.")] = "deck",
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="Write the sweep (YAML) that computes it.")
    ] = None,
    run: Annotated[Path | None, typer.Option("--run", metavar="DIR", help="Compute it into this folder.")] = None,
    threads: Threads = None,
    as_json: Json = False,
) -> None:
    """Read a deck of MPM3D, print what was understood, and compute it or write its sweep."""
    from studies.sweeps.sweep import Sweep

    text = _text_of(file)
    read = read_deck(text, units)
    if as_json:
        summary = {"nodes": read.nodes, "particles": read.particles}
        plain = asdict(read)
        for body in plain["bodies"]:
            del body["rows"]
        print_json({**summary, **plain})
    else:
        _print_deck(read)
    document: dict[str, Plain] = {
        "name": file.stem[:100],
        "title": (read.title or file.stem)[:100],
        "scenario": "deck",
        "fixed": {"deck": text, "units": units},
        "axes": {"end_time": [f"{read.end_time!r} s"]},
    }
    Sweep.parse(document).runs()
    if output is not None:
        _write(output, text, units, document)
    if run is not None:
        raise typer.Exit(compute(document, file.stem, folder_of(run), threads=threads))


def _text_of(file: Path) -> str:
    try:
        with file.open("rb") as opened:
            content = opened.read(MOST_BYTES + 1)
    except FileNotFoundError:
        raise no_such_file(file) from None
    except OSError as error:
        raise refusal("deck", str(file), "a file that can be read", f"choose another file: {error.strerror}") from None
    return read_file_text(content)


def _print_deck(deck: Deck) -> None:
    """Tables of the grid, the bodies and the materials, and what is left out."""
    print_table(("", "understood"), _grid(deck))
    print()
    bodies = enumerate(deck.bodies, 1)
    print_table(
        ("body", "component", "material", "particles", "line"),
        [tuple(map(str, (number, b.component, b.material, b.count, b.line))) for number, b in bodies],
    )
    print()
    print_table(
        ("material", "kind", "equation of state", "constants (SI)"),
        [
            (
                *(str(number), material.kind, material.eos or "linear"),
                ", ".join(
                    [*(f"{name} {value:g}" for name, value in material.values.items()), *_plain(material.eos_values)]
                ),
            )
            for number, material in deck.materials.items()
        ],
    )
    if deck.velocities:
        print()
        rows = [(moved.of, str(moved.number), " ".join(_plain(moved.velocity))) for moved in deck.velocities]
        print_table(("velocity of", "number", "m/s"), rows)
    if deck.unused:
        print(f"\nwithout effect here: {', '.join(deck.unused)}")


def _grid(deck: Deck) -> Iterator[tuple[str, str]]:
    """What was understood of the grid and the numerics, in words."""
    yield "title", deck.title
    yield "units", deck.units
    yield "grid", f"{' x '.join(map(str, deck.cells))} cells of {deck.cell * 1e3:g} mm"
    yield "nodes", str(deck.nodes)
    yield "particles", str(deck.particles)
    yield "end", f"{deck.end_time * 1e6:g} us, steps of {fixed_step(deck) * 1e9:.4g} ns"
    yield "numerics", f"{deck.shape}, {deck.scheme}, viscosity {' '.join(_plain(deck.viscosity))}"
    yield "contact", f"on the nodes, friction {deck.friction:g}" if deck.contact else "none"
    for axis, name in enumerate("xyz"):
        low, high = deck.lower[axis] * 1e3, (deck.lower[axis] + deck.cells[axis] * deck.cell) * 1e3
        faces = " ".join(FACES[face] for face in deck.faces[2 * axis : 2 * axis + 2])
        yield f"faces of {name}", f"{low:g} to {high:g} mm: {faces}"
    for place in deck.detonations:
        yield "detonation", f"{' '.join(_plain(1e3 * x for x in place))} mm"
    if any(deck.gravity):
        yield "gravity", f"{' '.join(_plain(deck.gravity))} m/s2"


def _plain(numbers: Iterable[float]) -> list[str]:
    return [f"{number:g}" for number in numbers]


def _write(output: Path, deck: str, units: str, document: Mapping[str, Plain]) -> None:
    """The sweep as YAML, with the deck as a block of its own lines."""
    lines = [line.expandtabs().rstrip() for line in deck.splitlines()]
    fixed = {"deck": "\n".join(lines) + "\n", "units": units}
    try:
        output.write_text(yaml_of({**document, "fixed": fixed}), "utf-8")
    except OSError as error:
        raise refusal("--output", str(output), "a file", f"choose another file: {error.strerror}") from None
    print(f"\nwritten: {output}; compute it with: whipple sweep {output} --out DIR")
