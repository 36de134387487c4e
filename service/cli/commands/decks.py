"""Decks of MPM3D: what one says, and the sweep that computes it."""

from pathlib import Path
from typing import Annotated, Any

import typer

from service.cli.commands.computing import compute
from service.cli.commands.options import Json, Threads, folder_of
from service.cli.console import print_json, print_table
from studies.decks.deck import Deck
from studies.decks.problem import fixed_step
from studies.decks.reader import MOST_BYTES, read_deck, read_file_text
from studies.quantities.findings import Finding, InvalidInput
from studies.sweeps.document import no_such_file

app = typer.Typer()

FACES = ("free", "fixed", "symmetric")


@app.command()
def deck(
    file: Annotated[Path, typer.Argument(metavar="FILE.mpm", help="An input file of MPM3D.")],
    units: Annotated[str, typer.Option(metavar="deck|mm-g-ms|SI", help="Units; by default those it names.")] = "deck",
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
    if units not in ("deck", "mm-g-ms", "SI"):
        raise InvalidInput([Finding("--units", units, "deck, mm-g-ms or SI", "write one of these")])
    read = read_deck(text, units)
    if as_json:
        from dataclasses import asdict

        summary = {"nodes": read.nodes, "particles": read.particles}
        plain = asdict(read)
        for body in plain["bodies"]:
            del body["rows"]
        print_json({**summary, **plain})
    else:
        _print_deck(read)
    document = {
        "name": file.stem[:100],
        "title": (read.title or file.stem)[:100],
        "scenario": "deck",
        "fixed": {"deck": text, "units": units},
        "axes": {"end_time": [f"{read.end_time!r} s"]},
    }
    Sweep.parse(document).runs()
    if output is not None:
        _write(output, document)
    if run is not None:
        raise typer.Exit(compute(document, file.stem, folder_of(run), threads=threads))


def _text_of(file: Path) -> str:
    try:
        with file.open("rb") as opened:
            content = opened.read(MOST_BYTES + 1)
    except FileNotFoundError:
        raise no_such_file(file) from None
    except OSError as error:
        cure = f"choose another file: {error.strerror}"
        raise InvalidInput([Finding("deck", str(file), "a file that can be read", cure)]) from None
    return read_file_text(content)


def _print_deck(deck: Deck) -> None:
    """Tables of the grid, the bodies and the materials, and what is left out."""
    end = f"{deck.end_time * 1e6:g} us, steps of {fixed_step(deck) * 1e9:.4g} ns"
    numerics = f"{deck.shape}, {deck.scheme}, viscosity {deck.viscosity[0]:g} {deck.viscosity[1]:g}"
    contact = f"on the nodes, friction {deck.friction:g}" if deck.contact else "none"
    rows = [
        ("title", deck.title),
        ("units", deck.units),
        ("grid", f"{' x '.join(map(str, deck.cells))} cells of {deck.cell * 1e3:g} mm"),
        ("nodes", str(deck.nodes)),
        ("particles", str(deck.particles)),
        ("end", end),
        ("numerics", numerics),
        ("contact", contact),
    ]
    for axis, name in enumerate("xyz"):
        low = deck.lower[axis]
        high = low + deck.cells[axis] * deck.cell
        faces = " ".join(FACES[face] for face in deck.faces[2 * axis : 2 * axis + 2])
        rows.append((f"faces of {name}", f"{low * 1e3:g} to {high * 1e3:g} mm: {faces}"))
    rows += [("detonation", " ".join(f"{x * 1e3:g}" for x in at) + " mm") for at in deck.detonations]
    if any(deck.gravity):
        rows.append(("gravity", " ".join(f"{each:g}" for each in deck.gravity) + " m/s2"))
    print_table(("", "understood"), rows)
    print()
    print_table(
        ("body", "component", "material", "particles", "line"),
        [
            (str(number), *map(str, (body.component, body.material, body.count, body.line)))
            for number, body in enumerate(deck.bodies, 1)
        ],
    )
    print()
    print_table(
        ("material", "kind", "equation of state", "constants (SI)"),
        [
            (
                *(str(number), each.kind, each.eos or "linear"),
                ", ".join(f"{name} {value:g}" for name, value in each.values.items())
                + "".join(f", {value:g}" for value in each.eos_values),
            )
            for number, each in deck.materials.items()
        ],
    )
    if deck.velocities:
        print()
        print_table(
            ("velocity of", "number", "m/s"),
            [(each.of, str(each.number), " ".join(f"{v:g}" for v in each.velocity)) for each in deck.velocities],
        )
    if deck.unused:
        print(f"\nwithout effect here: {', '.join(deck.unused)}")


def _write(output: Path, document: dict[str, Any]) -> None:
    """The sweep as YAML, with the deck as a block of its own lines."""
    import yaml

    class Dumper(yaml.SafeDumper):
        """Texts of several lines as blocks."""

    def block(dumper: Any, text: str) -> Any:
        style = "|" if "\n" in text else None
        return dumper.represent_scalar("tag:yaml.org,2002:str", text, style=style)

    Dumper.add_representer(str, block)
    lines = [line.expandtabs().rstrip() for line in document["fixed"]["deck"].splitlines()]
    fixed = {**document["fixed"], "deck": "\n".join(lines) + "\n"}
    content = yaml.dump({**document, "fixed": fixed}, Dumper=Dumper, sort_keys=False, allow_unicode=True)
    try:
        output.write_text(content, "utf-8")
    except OSError as error:
        cure = f"choose another file: {error.strerror}"
        raise InvalidInput([Finding("--output", str(output), "a file", cure)]) from None
    print(f"\nwritten: {output}; compute it with: whipple sweep {output} --out DIR")
