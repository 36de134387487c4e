"""The map of the house: ``make map`` prints it, draws docs/house.svg, and writes docs/house.md.

A room is a module or folder directly inside a folder, an arrow an import between two rooms of it. The floor of a room
is one above the highest that it imports; rooms that import one another in a circle have none.
"""

import ast
import html
import re
import sys
from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from graphlib import CycleError, TopologicalSorter
from itertools import pairwise
from pathlib import Path

import grimp

ROOT = Path(__file__).parents[1]
PACKAGES = ("service", "studies", "solver")
PICTURE, PAGE = ROOT / "docs" / "house.svg", ROOT / "docs" / "house.md"


@dataclass(frozen=True)
class Folder:
    """A folder as its imports show it."""

    name: str  # "studies.laws"
    rooms: tuple[str, ...]
    arrows: frozenset[tuple[str, str]]  # (importing room, imported room)

    @cached_property
    def circle(self) -> list[str]:
        """Rooms that import one another, the first one again at the end; empty where there are none."""
        return next(circles(self._imported), [])

    @cached_property
    def floors(self) -> list[list[str]]:
        """Rooms from the lowest floor up; needs a folder without a circle."""
        floor: dict[str, int] = {}
        for room in TopologicalSorter(self._imported).static_order():
            floor[room] = 1 + max((floor[below] for below in self._imported[room]), default=-1)
        return [sorted(room for room in floor if floor[room] == level) for level in range(max(floor.values()) + 1)]

    @cached_property
    def _imported(self) -> dict[str, set[str]]:
        return {room: {b for a, b in self.arrows if a == room} for room in self.rooms}


@dataclass(frozen=True)
class House:
    """All files of the packages, and what each imports."""

    imported: Mapping[str, frozenset[str]]  # modules by module

    def folder(self, name: str) -> Folder:
        """The rooms of a folder."""
        rooms, arrows = set(), set()
        for module, others in self.imported.items():
            if room := _room(name, module):
                rooms.add(room)
                arrows |= {(room, other) for other in (_room(name, each) for each in others) if other and other != room}
        return Folder(name, tuple(sorted(rooms)), frozenset(arrows))

    def folders(self) -> list[Folder]:
        """Every folder with a module inside."""
        return [self.folder(name) for name in sorted({module.rpartition(".")[0] for module in self.imported} - {""})]

    def circles(self) -> list[list[str]]:
        """Files that import one another, a circle each."""
        return list(circles({module: set(others) for module, others in self.imported.items()}))


def house() -> House:
    """The house as it is now."""
    graph = grimp.build_graph(*PACKAGES)
    return House({module: frozenset(graph.find_modules_directly_imported_by(module)) for module in graph.modules})


def circles(imported: Mapping[str, set[str]]) -> Iterator[list[str]]:
    """Circles of a graph, each without an arrow of those before it."""
    left = {name: set(others) for name, others in imported.items()}
    while True:
        try:
            TopologicalSorter(left).prepare()
        except CycleError as error:
            circle: list[str] = error.args[1][::-1]  # in the direction of the imports
            yield circle
            for name, other in pairwise(circle):
                left[name].discard(other)
        else:
            return


def _room(folder: str, module: str) -> str:
    """The room of a folder in which a module lies; empty for one outside, and for the folder itself."""
    return module.removeprefix(f"{folder}.").split(".")[0] if module.startswith(f"{folder}.") else ""


def _files() -> Iterator[Path]:
    for package in PACKAGES:
        yield from sorted((ROOT / package).rglob("*.py"))


def names_defined_twice() -> dict[str, list[str]]:
    """Names of classes, and of types that a module gives a name, which several places define, and their files."""
    places: defaultdict[str, list[str]] = defaultdict(list)
    for file in _files():
        tree = ast.parse(file.read_text())
        classes = [node.name for node in ast.walk(tree) if isinstance(node, ast.ClassDef)]
        for name in [*classes, *filter(None, map(_alias, tree.body))]:
            places[name].append(str(file.relative_to(ROOT)))
    return {name: files for name, files in sorted(places.items()) if len(files) > 1}


def _alias(node: ast.stmt) -> str | None:
    """The name that a statement of a module gives to a type: ``Kind = Literal["run", "publish"]``."""
    if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
        is_alias = ast.unparse(node.annotation).endswith("TypeAlias")
        return node.target.id if is_alias else None
    if not (isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name)):
        return None
    name, value = node.targets[0].id, node.value
    is_union = isinstance(value, ast.BinOp) and isinstance(value.op, ast.BitOr)
    is_new = isinstance(value, ast.Call) and ast.unparse(value.func).endswith("NewType")
    is_type = is_union or is_new or isinstance(value, ast.Subscript)
    return name if is_type and re.fullmatch(r"_?[A-Z]\w*[a-z]\w*", name) else None


def lines_under(folder: Path) -> int:
    """Lines of all Python files under a folder."""
    return sum(len(file.read_text().splitlines()) for file in folder.rglob("*.py"))


def _path(module: str) -> Path:
    path = ROOT / module.replace(".", "/")
    return path / "__init__.py" if path.is_dir() else path.with_suffix(".py")


# --- the picture and the page -----------------------------------------------------------------------

WIDTH, HEIGHT, GAP, MARGIN = 118, 26, 12, 16  # of a room, between rooms, around the picture; px
FLOOR = 54  # from floor to floor, px


def _picture(folder: Folder) -> tuple[str, int, int]:
    """A package as an SVG group with its width and height: floors from the bottom up, an arrow for each import."""
    widest = max(len(floor) for floor in folder.floors)
    width = 2 * MARGIN + widest * (WIDTH + GAP) - GAP
    height = 2 * MARGIN + len(folder.floors) * FLOOR
    places = {}
    for level, floor in enumerate(folder.floors):
        left = (width - len(floor) * (WIDTH + GAP) + GAP) / 2
        for index, room in enumerate(floor):
            places[room] = (left + index * (WIDTH + GAP), height - MARGIN - (level + 1) * FLOOR + 14)
    parts = [
        f'<line x1="{places[a][0] + WIDTH / 2:.0f}" y1="{places[a][1] + HEIGHT:.0f}" '
        f'x2="{places[b][0] + WIDTH / 2:.0f}" y2="{places[b][1]:.0f}" class="arrow"/>'
        for a, b in sorted(folder.arrows)
    ]
    for room, (x, y) in places.items():
        parts += [
            f'<rect x="{x:.0f}" y="{y:.0f}" width="{WIDTH}" height="{HEIGHT}" rx="4"/>',
            f'<text x="{x + WIDTH / 2:.0f}" y="{y + 17:.0f}">{html.escape(room)}</text>',
        ]
    return f'<g id="{folder.name}">' + "\n".join(parts) + "</g>", width, height


def drawing(packages: list[Folder]) -> str:
    """All packages above one another, as one SVG file."""
    groups, top, widest = [], 0, 0
    for folder in packages:
        group, width, height = _picture(folder)
        title = f'<text x="{MARGIN}" y="{top + 18}" class="title">{folder.name}/</text>'
        groups.append(f'{title}<g transform="translate(0 {top + 20})">{group}</g>')
        top, widest = top + 20 + height, max(widest, width)
    style = (
        "rect{fill:#fff;stroke:#555}text{font:12px sans-serif;text-anchor:middle;fill:#111}"
        ".title{font-weight:bold;text-anchor:start}.arrow{stroke:#4a7ab5;stroke-opacity:.45}"
    )
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {widest} {top}" '
        f'width="{widest}" height="{top}"><style>{style}</style>'
        f'<rect width="100%" height="100%" style="stroke:none"/>' + "\n".join(groups) + "</svg>\n"
    )


def page(packages: list[Folder]) -> str:
    """Every room of the packages with the first sentence of its docstring, from the highest floor down."""
    lines = [
        "# The house",
        "",
        "`service -> studies -> solver`: HTTP in and files out, questions and answers, physics. Inside each a room",
        "imports lower floors only. `make map` writes this page from the first sentence of each room's docstring.",
        "",
        "![Rooms of the service, the studies and the solver, and what each imports](house.svg)",
    ]
    for folder in packages:
        lines += ["", f"## {folder.name}", "", _sentence(folder.name), "", "| room | what it is |", "|---|---|"]
        for room in (room for floor in reversed(folder.floors) for room in floor):
            name = "/".join(_path(f"{folder.name}.{room}").relative_to(ROOT).parts).removesuffix("__init__.py")
            lines.append(f"| `{name}` | {_sentence(f'{folder.name}.{room}')} |")
    return "\n".join(lines) + "\n"


def _sentence(module: str) -> str:
    """The first sentence of a docstring, as a cell of a table."""
    text = ast.get_docstring(ast.parse(_path(module).read_text())) or ""
    words = " ".join(text.partition("\n\n")[0].split())
    return re.split(r"(?<=\.) (?=[A-Z`])", words)[0].replace("``", "`").replace("|", r"\|")


def main() -> None:
    """Print the map, and draw it where no package has a circle."""
    whole = house()
    packages = [whole.folder(name) for name in PACKAGES]
    for folder in packages:
        total = lines_under(ROOT / folder.name)
        print(f"{folder.name}: {len(folder.rooms)} rooms, {len(folder.arrows)} arrows, {total} lines")
        for level, floor in [] if folder.circle else reversed(list(enumerate(folder.floors, 1))):
            print(f"  floor {level}: " + ", ".join(f"{room} ({_lines(folder.name, room)})" for room in floor))
    print(f"tests: {lines_under(ROOT / 'tests')} lines")
    for folder in whole.folders():
        if folder.circle:
            print(f"circle in {folder.name}: {' -> '.join(folder.circle)}")
    for circle in whole.circles():
        print(f"circle of files: {' -> '.join(circle)}")
    for name, files in names_defined_twice().items():
        print(f"{name} is defined in {', '.join(files)}")
    if any(folder.circle for folder in packages):
        sys.exit("a circle of imports has no floors to draw")
    PICTURE.write_text(drawing(packages), encoding="utf-8")
    PAGE.write_text(page(packages), encoding="utf-8")
    print(f"written: {PICTURE.relative_to(ROOT)}, {PAGE.relative_to(ROOT)}")


def _lines(package: str, room: str) -> int:
    path = ROOT / package / room
    return lines_under(path) if path.is_dir() else len(path.with_suffix(".py").read_text().splitlines())


if __name__ == "__main__":
    main()
