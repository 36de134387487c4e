"""The catalogue that ships: materials, laws and scenarios; no service is needed."""

from collections.abc import Iterable
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from service.cli.commands import SHIPPED, Commands
from service.cli.console import print_json, print_table, value_with_unit
from service.cli.options import Json
from studies.quantities.parameters import Parameter, declared

if TYPE_CHECKING:
    from studies.laws import Law
    from studies.materials import Material
    from studies.scenarios import Scenario

app = typer.Typer()
COMMANDS = Commands("catalogue", SHIPPED, app)


@app.command("list")
def list_kind(
    kind: Annotated[
        Literal["materials", "laws", "scenarios"], typer.Argument(metavar="KIND", help="materials, laws or scenarios.")
    ],
    name: Annotated[str | None, typer.Argument(metavar="[NAME]", help="Show this one in full.")] = None,
    as_json: Json = False,
) -> None:
    """List the materials, the published laws or the scenarios, or show one with units and sources."""
    from studies import laws, materials, scenarios

    if as_json:
        if kind == "materials":
            documents = [materials.load(entry).document() for entry in ([name] if name else materials.names())]
        else:
            shipped = laws if kind == "laws" else scenarios
            documents = [shipped.load(entry).describe() for entry in ([name] if name else shipped.names())]
        print_json(documents[0] if name else documents)
    elif kind == "materials":
        _show_material(materials.load(name)) if name else _list_materials(map(materials.load, materials.names()))
    elif kind == "laws":
        _show_law(laws.load(name)) if name else _list_laws(map(laws.load, laws.names()))
    else:
        _show_scenario(scenarios.load(name)) if name else _list_scenarios(map(scenarios.load, scenarios.names()))


@app.command()
def schema() -> None:
    """Print the JSON Schema of a sweep, for editors: whipple schema > sweep.schema.json, beside its file."""
    from studies.sweeps.schema import schema_of_sweep

    print_json(schema_of_sweep())


def _list_materials(listed: "Iterable[Material]") -> None:
    rows = (
        (
            *(metal.name, metal.title, metal.family),
            value_with_unit(metal.density, metal.sources["density"].unit),
            *(metal.eos.kind, metal.strength.kind),
        )
        for metal in listed
    )
    print_table(("name", "title", "family", "density", "equation of state", "strength"), rows)


def _show_material(material: "Material") -> None:
    print(f"{material.name}: {material.title} ({material.family}; {material.eos.kind}, {material.strength.kind})")
    stated = sorted(material.sources.items(), key=lambda item: item[0].startswith("yield_stresses."))
    rows = (
        (
            path.replace("yield_stresses.", "yield stress: "),
            value_with_unit(constant.value, constant.unit),
            *(constant.confidence, constant.source),
        )
        for path, constant in stated
    )
    print_table(("constant", "value", "confidence", "source"), rows)


def _list_laws(listed: "Iterable[Law]") -> None:
    rows = ((law.name, law.title, law.quantity, law.use.partition(" (")[0]) for law in listed)
    print_table(("name", "title", "quantity", "use"), rows)


def _show_law(law: "Law") -> None:
    from studies.laws import limit_in_words

    print(f"{law.name}: {law.title}, for {law.quantity}")
    print(f"  equation  {law.equation}")
    print(f"  source    {law.source} ({law.confidence})")
    print(f"  use       {law.use}")
    scatter = "not published" if law.scatter is None else f"{law.scatter:.0%} (relative standard deviation)"
    print(f"  scatter   {scatter}")
    rows = (
        (limit_in_words(limit), limit.source, "yes" if limit.machine_checked else "no") for limit in law.range.every
    )
    print_table(("range", "source of the limit", "checked"), rows)


def _list_scenarios(listed: "Iterable[Scenario]") -> None:
    print_table(("name", "title", "measures"), ((s.name, s.title, ", ".join(s.measurements)) for s in listed))


def _show_scenario(scenario: "Scenario") -> None:
    print(f"{scenario.name}: {scenario.title}\n{scenario.description}")
    print(f"measures: {', '.join(scenario.measurements)}")
    parameters = declared(scenario.parameters).values()
    rows = ((p.name, _default(p), p.limit(), p.meaning) for p in parameters)
    print_table(("parameter", "default", "allowed", "meaning"), rows)


def _default(parameter: Parameter) -> str:
    if parameter.required:
        return "required"
    return "" if parameter.default is None else value_with_unit(parameter.default, parameter.unit)
