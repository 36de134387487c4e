"""Features: folders that can be taken away. ``[tool.whipple.features]`` of pyproject.toml lists them.

import-linter holds, by ``SpineWithoutFeatures``, that nothing imports a feature but itself and features that need it.
"""

import tomllib
from dataclasses import dataclass
from pathlib import Path

from grimp import ImportGraph
from importlinter import Contract, ContractCheck, fields, output
from importlinter.application.contract_utils import AlertLevel, remove_ignored_imports

ROOT = Path(__file__).parents[2]


@dataclass(frozen=True)
class Feature:
    """What can be taken away together."""

    name: str
    folders: tuple[str, ...]  # or modules, on each floor that it needs: "studies.shields"
    needs: tuple[str, ...] = ()  # names of other features

    def has(self, module: str) -> bool:
        """Whether a module is part of it."""
        return any(f"{module}.".startswith(f"{folder}.") for folder in self.folders)


def features() -> dict[str, Feature]:
    """Those that the project lists, by name."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    listed = project["tool"]["whipple"]["features"]
    return {name: Feature(name, tuple(of["folders"]), tuple(of.get("needs", ()))) for name, of in listed.items()}


class SpineWithoutFeatures(Contract):
    """The spine imports no feature, and a feature only those that it needs."""

    type_name = "features"

    ignore_imports = fields.SetField(subfield=fields.ImportExpressionField(), required=False)

    def check(self, graph: ImportGraph, verbose: bool) -> ContractCheck:
        """Every import of a feature by what may not import it."""
        warnings = remove_ignored_imports(graph, self.ignore_imports, AlertLevel.NONE)  # type: ignore[arg-type]
        wrong = [
            f"{importer} -> {module}"
            for feature in features().values()
            for module in filter(feature.has, graph.modules)
            for importer in graph.find_modules_that_directly_import(module)
            if not self._may_import(importer, feature)
        ]
        return ContractCheck(kept=not wrong, warnings=warnings, metadata={"wrong": sorted(wrong)})

    def render_broken_contract(self, check: ContractCheck) -> None:
        """Print the imports."""
        for arrow in check.metadata["wrong"]:
            output.print_error(arrow)

    @staticmethod
    def _may_import(importer: str, feature: Feature) -> bool:
        users = (other for other in features().values() if other == feature or feature.name in other.needs)
        return any(user.has(importer) for user in users)
