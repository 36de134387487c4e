"""The catalogue that ships: materials, laws and scenarios, as the API lists them; no service is needed."""

from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Annotated, Any

import typer

from service.cli.commands.answering import print_answers
from service.cli.commands.options import Json
from service.cli.console import print_json, print_table
from studies.quantities.units import readable

app = typer.Typer()

Description = Mapping[str, Any]  # of an entry
Name = Annotated[str | None, typer.Argument(metavar="[NAME]", help="Show this one in full.")]


@app.command()
def materials(name: Name = None, as_json: Json = False) -> None:
    """List the materials, or the constants of one with unit, source and confidence."""
    from studies import materials as shipped

    _show(name, as_json, shipped.names(), lambda each: shipped.load(each).document(), _list_materials, _show_material)


def _quantity(flag: str, words: str) -> Any:
    return typer.Option(flag, metavar="QUANTITY", help=words)


@app.command()
def laws(
    name: Name = None,
    at: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Ask every law about the shots of a file (YAML or JSON).")
    ] = None,
    speed: Annotated[str | None, _quantity("--speed", "Ask about a shot at this speed: 6 km/s.")] = None,
    projectile: Annotated[str | None, typer.Option(metavar="MATERIAL", help="Material of the projectile.")] = None,
    projectile_diameter: Annotated[str | None, _quantity("--diameter", "Diameter of the projectile: 5 mm.")] = None,
    projectile_length: Annotated[str | None, _quantity("--length", "Length of a cylinder; none: a sphere.")] = None,
    target: Annotated[str | None, typer.Option(metavar="MATERIAL", help="Material of a plate or a block.")] = None,
    plate_thickness: Annotated[str | None, _quantity("--thickness", "Of a plate; none: a block.")] = None,
    bumper: Annotated[str | None, typer.Option(metavar="MATERIAL", help="Bumper of a shield.")] = None,
    bumper_thickness: Annotated[str | None, _quantity("--bumper-thickness", "Of a shield's bumper.")] = None,
    stand_off: Annotated[str | None, _quantity("--stand-off", "Between bumper and wall of a shield: 10 cm.")] = None,
    wall_thickness: Annotated[str | None, _quantity("--wall-thickness", "Thickness of a shield's wall.")] = None,
    wall: Annotated[str | None, typer.Option(metavar="MATERIAL", help="A shield's wall; none: as its bumper.")] = None,
    obliquity: Annotated[str | None, _quantity("--obliquity", "Angle from the target's normal: 45 deg.")] = None,
    out: Annotated[
        Path | None, typer.Option(help="Write the answer: .html, .svg, .png or .pdf, or laws.nc of many shots.")
    ] = None,
    as_json: Json = False,
) -> None:
    """List the published laws, show one, or ask all of them about a shot: --at FILE, or --speed, --projectile, ..."""
    from studies import laws as shipped

    names: tuple[str, ...] = ("speed", "projectile", "projectile_diameter", "projectile_length", "target")
    names += ("plate_thickness", "bumper", "bumper_thickness", "stand_off", "wall_thickness", "wall", "obliquity")
    options = locals()
    given = {each: options[each] for each in names if options[each] is not None}
    if at is not None or given:
        print_answers(at, given, out, as_json=as_json)
        return
    _show(name, as_json, shipped.names(), lambda each: shipped.load(each).describe(), _list_laws, _show_law)


@app.command()
def scenarios(name: Name = None, as_json: Json = False) -> None:
    """List the scenarios, or the parameters of one with limits and defaults."""
    from studies import scenarios as shipped

    _show(name, as_json, shipped.names(), lambda each: shipped.load(each).describe(), _list_scenarios, _show_scenario)


def _show(
    name: str | None,
    as_json: bool,
    names: Iterable[str],
    describe: Callable[[str], Description],
    show_all: Callable[[list[Description]], None],
    show_entry: Callable[[Description], None],
) -> None:
    """Print an entry, or the list of all; raises InvalidInput for an unknown name."""
    if name is not None:
        entry = describe(name)
        print_json(entry) if as_json else show_entry(entry)
        return
    entries = [describe(each) for each in names]
    print_json(entries) if as_json else show_all(entries)


def _list_materials(entries: list[Description]) -> None:
    rows = (
        (
            *(entry["name"], entry["title"], entry["family"], _value(entry["density"])),
            *(entry["eos"]["kind"], entry["strength"]["kind"]),
        )
        for entry in entries
    )
    print_table(("name", "title", "family", "density", "equation of state", "strength"), rows)


def _show_material(material: Description) -> None:
    print(f"{material['name']}: {material['title']} ({material['family']})")
    rows = [(path, _value(each), each["confidence"], each["source"]) for path, each in _constants(material)]
    rows += [
        (f"yield stress: {each['label']}", _value(each), each["confidence"], each["source"])
        for each in material["yield_stresses"]
    ]
    print_table(("constant", "value", "confidence", "source"), rows)


def _constants(material: Description) -> Iterable[tuple[str, Description]]:
    """The constants of a material by dotted path; the kind of a section first."""
    for key, entry in material.items():
        if isinstance(entry, Mapping):
            if "value" in entry:
                yield key, entry
                continue
            for name, constant in entry.items():
                kind = {"value": constant, "unit": None, "source": "", "confidence": ""}
                yield f"{key}.{name}", constant if isinstance(constant, Mapping) else kind


def _list_laws(entries: list[Description]) -> None:
    from studies.laws import DRAWN_ONLY

    uses = ("drawn only" if law["confidence"] in DRAWN_ONLY else "verdict" for law in entries)
    rows = ((law["name"], law["title"], law["quantity"], use) for law, use in zip(entries, uses, strict=True))
    print_table(("name", "title", "quantity", "use"), rows)


def _show_law(law: Description) -> None:
    print(f"{law['name']}: {law['title']}, for {law['quantity']}")
    print(f"  equation  {law['equation']}")
    print(f"  source    {law['source']} ({law['confidence']})")
    print(f"  use       {law['use']}")
    scatter = law["scatter"]
    words = "not published" if scatter is None else f"{scatter:.0%} (relative standard deviation)"
    print(f"  scatter   {words}")
    rows = ((each["words"], each["source"], "yes" if each["machine_checked"] else "no") for each in law["range"])
    print_table(("range", "source of the limit", "checked"), rows)


def _list_scenarios(entries: list[Description]) -> None:
    rows = ((each["name"], each["title"], ", ".join(each["measurements"])) for each in entries)
    print_table(("name", "title", "measures"), rows)


def _show_scenario(scenario: Description) -> None:
    print(f"{scenario['name']}: {scenario['title']}\n{scenario['description']}")
    print(f"measures: {', '.join(scenario['measurements'])}")
    rows = ((each["name"], _default(each), each["limit"], each["meaning"]) for each in scenario["parameters"])
    print_table(("parameter", "default", "allowed", "meaning"), rows)


def _default(parameter: Description) -> str:
    if parameter["required"]:
        return "required"
    return "" if parameter["default"] is None else _value({"value": parameter["default"], **parameter})


def _value(quantity: Description) -> str:
    """A value with its unit, as a sweep document writes it."""
    value, unit = quantity["value"], quantity["unit"]
    if isinstance(value, bool):
        return "true" if value else "false"
    return readable(value, unit) if unit and isinstance(value, int | float) else str(value)
