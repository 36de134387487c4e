"""The map of the house: ``make map`` prints rooms, arrows, floors, circles and lines of each package, and draws them.

A room is a module or folder directly inside a package, an arrow an import between two rooms. The floor of a room is one
above the highest that it imports; rooms that import one another in a circle have none.
"""

import ast
import html
import sys
from collections import Counter
from dataclasses import dataclass
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import grimp

ROOT = Path(__file__).parents[1]
PACKAGES = ("service", "studies", "solver")
PICTURE = ROOT / "docs" / "house.svg"


@dataclass(frozen=True)
class House:
    """One package as its imports show it."""

    package: str
    lines: dict[str, int]  # of each room
    arrows: frozenset[tuple[str, str]]  # (importing room, imported room)

    @property
    def circle(self) -> list[str]:
        """Rooms that import one another, the first one again at the end; empty where there are none."""
        try:
            TopologicalSorter(self._imported()).prepare()
        except CycleError as error:
            circle: list[str] = error.args[1]
            return circle
        return []

    @property
    def floors(self) -> list[list[str]]:
        """Rooms from the lowest floor up; needs a house without a circle."""
        imported = self._imported()
        floor: dict[str, int] = {}
        for room in TopologicalSorter(imported).static_order():
            floor[room] = 1 + max((floor[below] for below in imported[room]), default=-1)
        return [sorted(room for room in floor if floor[room] == level) for level in range(max(floor.values()) + 1)]

    def _imported(self) -> dict[str, set[str]]:
        return {room: {b for a, b in self.arrows if a == room} for room in self.lines}


def houses() -> list[House]:
    """All packages."""
    graph = grimp.build_graph(*PACKAGES)
    return [_house(graph, package) for package in PACKAGES]


def classes_defined_twice() -> dict[str, list[str]]:
    """Names of classes that more than one place of the packages defines, and the files."""
    places: dict[str, list[str]] = {}
    for package in PACKAGES:
        for file in sorted((ROOT / package).rglob("*.py")):
            for node in ast.walk(ast.parse(file.read_text())):
                if isinstance(node, ast.ClassDef):
                    places.setdefault(node.name, []).append(str(file.relative_to(ROOT)))
    return {name: files for name, files in sorted(places.items()) if len(files) > 1}


def lines_under(folder: Path) -> int:
    """Lines of all Python files under a folder."""
    return sum(len(file.read_text().splitlines()) for file in folder.rglob("*.py"))


def _house(graph: grimp.ImportGraph, package: str) -> House:
    lines: Counter[str] = Counter()
    arrows = set()
    for module in graph.modules:
        if module.startswith(f"{package}."):
            room = module.split(".")[1]
            lines[room] += _lines(module)
            for imported in graph.find_modules_directly_imported_by(module):
                owner, _, other = imported.partition(".")
                if owner == package and other and other.split(".")[0] != room:
                    arrows.add((room, other.split(".")[0]))
    return House(package, dict(sorted(lines.items())), frozenset(arrows))


def _lines(module: str) -> int:
    path = ROOT / module.replace(".", "/")
    file = path / "__init__.py" if path.is_dir() else path.with_suffix(".py")
    return len(file.read_text().splitlines())


WIDTH, HEIGHT, GAP, MARGIN = 118, 34, 12, 16  # of a room, between rooms, around the picture; px
FLOOR = 62  # from floor to floor, px


def picture(house: House) -> tuple[str, int, int]:
    """The package as an SVG group with its width and height: floors from the bottom up, an arrow for each import."""
    floors = house.floors
    widest = max(len(floor) for floor in floors)
    width = 2 * MARGIN + widest * (WIDTH + GAP) - GAP
    height = 2 * MARGIN + len(floors) * FLOOR
    places = {}
    for level, floor in enumerate(floors):
        left = (width - len(floor) * (WIDTH + GAP) + GAP) / 2
        for index, room in enumerate(floor):
            places[room] = (left + index * (WIDTH + GAP), height - MARGIN - (level + 1) * FLOOR + 14)
    parts = [
        f'<line x1="{places[a][0] + WIDTH / 2:.0f}" y1="{places[a][1] + HEIGHT:.0f}" '
        f'x2="{places[b][0] + WIDTH / 2:.0f}" y2="{places[b][1]:.0f}" class="arrow"/>'
        for a, b in sorted(house.arrows)
    ]
    for room, (x, y) in places.items():
        middle = x + WIDTH / 2
        parts += [
            f'<rect x="{x:.0f}" y="{y:.0f}" width="{WIDTH}" height="{HEIGHT}" rx="4"/>',
            f'<text x="{middle:.0f}" y="{y + 15:.0f}">{html.escape(room)}</text>',
            f'<text x="{middle:.0f}" y="{y + 28:.0f}" class="lines">{house.lines[room]} lines</text>',
        ]
    return f'<g id="{house.package}">' + "\n".join(parts) + "</g>", width, height


def drawing(packages: list[House]) -> str:
    """All packages above one another, as one SVG file."""
    groups, top, widest = [], 0, 0
    for house in packages:
        group, width, height = picture(house)
        title = f'<text x="{MARGIN}" y="{top + 18}" class="title">{house.package}/</text>'
        groups.append(f'{title}<g transform="translate(0 {top + 20})">{group}</g>')
        top, widest = top + 20 + height, max(widest, width)
    style = (
        "rect{fill:#fff;stroke:#555}text{font:12px sans-serif;text-anchor:middle;fill:#111}"
        ".lines{font-size:9px;fill:#666}.title{font-weight:bold;text-anchor:start}"
        ".arrow{stroke:#4a7ab5;stroke-opacity:.45}"
    )
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {widest} {top}" '
        f'width="{widest}" height="{top}"><style>{style}</style>'
        f'<rect width="100%" height="100%" style="stroke:none"/>' + "\n".join(groups) + "</svg>\n"
    )


def main() -> None:
    """Print the map, and draw it where no package has a circle."""
    packages = houses()
    for house in packages:
        total = lines_under(ROOT / house.package)
        print(f"{house.package}: {len(house.lines)} rooms, {len(house.arrows)} arrows, {total} lines")
        if house.circle:
            print(f"  circle: {' -> '.join(house.circle)}")
            continue
        for level, floor in reversed(list(enumerate(house.floors, 1))):
            print(f"  floor {level}: " + ", ".join(f"{room} ({house.lines[room]})" for room in floor))
    print(f"tests: {lines_under(ROOT / 'tests')} lines")
    for name, files in classes_defined_twice().items():
        print(f"class {name} is defined in {', '.join(files)}")
    if any(house.circle for house in packages):
        sys.exit("a circle of imports has no floors to draw")
    PICTURE.write_text(drawing(packages), encoding="utf-8")
    print(f"drawn: {PICTURE.relative_to(ROOT)}")


if __name__ == "__main__":
    main()
