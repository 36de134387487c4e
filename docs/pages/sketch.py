"""Sketches with dimensions, as SVG in a grey that reads on light and dark paper."""

from collections.abc import Sequence

WIDTH, HEIGHT = 680, 330
GREY, FILL, MARK = "#7f7f7f", "#7f7f7f55", "#0072b2"
HEAD = 5  # length of an arrow's head, px


class Sketch:
    """Elements of a drawing, in the order in which they are drawn; y goes down."""

    def __init__(self, title: str, height: int = HEIGHT):
        self.title = title
        self.height = height
        self.elements: list[str] = []

    def svg(self) -> str:
        """The file."""
        head = (
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {self.height}" role="img" '
            f'font-family="system-ui, sans-serif" font-size="13"><title>{self.title}</title>\n'
        )
        return head + "\n".join(self.elements) + "\n</svg>\n"

    def shape(self, points: Sequence[tuple[float, float]], fill: str = FILL) -> None:
        """A filled polygon."""
        places = " ".join(f"{x:g},{y:g}" for x, y in points)
        self.elements.append(f'<polygon points="{places}" fill="{fill}" stroke="{GREY}"/>')

    def path(self, points: Sequence[tuple[float, float]], colour: str = GREY) -> None:
        """A line through points."""
        places = " ".join(f"{x:g},{y:g}" for x, y in points)
        self.elements.append(f'<polyline points="{places}" fill="none" stroke="{colour}" stroke-width="2"/>')

    def dashed(self, x1: float, y1: float, x2: float, y2: float) -> None:
        """A thin dashed line."""
        self.elements.append(
            f'<line x1="{x1:g}" y1="{y1:g}" x2="{x2:g}" y2="{y2:g}" stroke="{GREY}" stroke-dasharray="5 4"/>'
        )

    def text(self, x: float, y: float, text: str, anchor: str = "middle", colour: str = GREY) -> None:
        """A label."""
        self.elements.append(f'<text x="{x:g}" y="{y:g}" text-anchor="{anchor}" fill="{colour}">{text}</text>')

    def across(self, x1: float, x2: float, y: float, label: str) -> None:
        """A horizontal dimension, with its label above."""
        self._arrow((x1, y), (x2, y), (HEAD, 0))
        self.text(0.5 * (x1 + x2), y - 5, label, colour=MARK)

    def along(self, x: float, y1: float, y2: float, label: str) -> None:
        """A vertical dimension, with its label to the right."""
        self._arrow((x, y1), (x, y2), (0, HEAD))
        self.text(x + 9, 0.5 * (y1 + y2) + 5, label, "start", MARK)

    def _arrow(self, begin: tuple[float, float], end: tuple[float, float], head: tuple[float, float]) -> None:
        (x1, y1), (x2, y2), (dx, dy) = begin, end, head
        heads = f"M{x1 + dx - dy},{y1 + dy - dx} L{x1},{y1} L{x1 + dx + dy},{y1 + dy + dx} "
        heads += f"M{x2 - dx - dy},{y2 - dy - dx} L{x2},{y2} L{x2 - dx + dy},{y2 - dy + dx}"
        self.elements.append(
            f'<path d="M{x1},{y1} L{x2},{y2} {heads}" fill="none" stroke="{MARK}" stroke-width="1.3"/>'
        )
