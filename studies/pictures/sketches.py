"""The sketch of a set-up, with its dimensions."""

from collections.abc import Callable, Sequence

from markupsafe import Markup
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse, Rectangle

from studies.pictures.section import DrawnSetUp
from studies.reports.drawing.canvas import INK, SOFT, arrow, as_svg, canvas, drawn_in_style, line, write
from studies.scenarios.parts.outline import Dimension, Shape

Placing = Callable[[float, float], tuple[float, float]]  # of a point (across, along; m), in points

# points
WIDTH = 330.0
ROOM = 210.0  # width of the set-up itself: labels stand beside it
TALLEST = 195.0  # of the set-up itself
ABOVE, BELOW = 50.0, 33.0  # room for flight and dimensions, and for dimensions below
APART = 7.0  # between a body and its dimension
LETTER = 5.25  # width of a letter of a label, on average
LINE = 11.0  # between the lines of a label
FLIGHT = 22.0  # length of the arrow of flight
BODY, WALL = "#f5f5f3", "#d9d9d9"  # fillings


def setup_sketch(setup: DrawnSetUp) -> Markup:
    """The set-up to scale."""
    with drawn_in_style():
        return as_svg(_sketch(setup), "full setup", setup.alt, "setup")


def _sketch(setup: DrawnSetUp) -> Figure:
    # Bodies come from above, whatever their coordinate says.
    shapes, sign = setup.outline.shapes, setup.outline.upward
    left, right = min(shape.left for shape in shapes), max(shape.right for shape in shapes)
    ends = [sign * end for shape in shapes for end in (shape.top, shape.bottom)]
    top, bottom = min(ends), max(ends)
    scale = min(ROOM / (right - left), TALLEST / (bottom - top))

    def place(across: float, along: float) -> tuple[float, float]:
        return (0.5 * (WIDTH - 45.0) + scale * (across - 0.5 * (left + right)), ABOVE + scale * (sign * along - top))

    middle, deepest = place(0.0, 0.0)[0], ABOVE + scale * (bottom - top)
    drawing = canvas(WIDTH, deepest + BELOW)
    axes = drawing.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set(xlim=(0.0, WIDTH), ylim=(deepest + BELOW, 0.0))
    axes.set_axis_off()
    for shape in shapes:
        _shape(axes, shape, place, sign, setup)
    line(axes, "plain", (middle, middle), (ABOVE - 9.0, deepest + 6.0))
    for dimension in setup.outline.dimensions:
        _dimension(axes, dimension, place, setup.labels[dimension.parameter])
    return drawing


def _shape(axes: Axes, shape: Shape, place: Placing, sign: float, setup: DrawnSetUp) -> None:
    """A body with its material, and its flight."""
    corners = place(shape.left, shape.top), place(shape.right, shape.bottom)
    (x, right), (y, bottom) = (sorted(ends) for ends in zip(*corners, strict=True))
    wide, tall, middle = right - x, bottom - y, 0.5 * (x + right)
    patch = Ellipse((middle, y + 0.5 * wide), wide, wide) if shape.is_disc else Rectangle((x, y), wide, tall)
    fill, edge = (WALL, SOFT) if shape.body == "wall" else (BODY, INK)
    patch.set(facecolor=fill, edgecolor=edge, linewidth=0.9, gid=f"kind:{shape.body}")
    axes.add_patch(patch)
    name = setup.materials.get(shape.body)
    if shape.heading:
        # An arrow above the body, in the direction in which it flies.
        (across, along), end = shape.heading, y - APART - 7.0
        begin = middle - FLIGHT * across, end - FLIGHT * sign * along
        arrow(axes, "flight", (begin[0], middle), (begin[1], end), both=False)
        write(axes, "plain", begin[0] + 6.0, begin[1] + 7.0, setup.labels.get("speed", ""), "left")
        if name:
            # Beside the arrow: its dimensions stand beside the body.
            left = middle - FLIGHT * max(0.0, across) - 9.0
            _lines(axes, left, y - APART - FLIGHT, _label(shape.body, name, left), "right")
    elif name and LETTER * len(shape.body) > 0.5 * wide - 7.5:  # beside the axis there is no room for it
        _lines(axes, x - 4.5, bottom + 8.0, _label(shape.body, name, 0.0), "right")
    elif name:
        # Left of the axis where the body is wide enough.
        lines = _label(shape.body, name, 0.5 * wide - 7.5)
        inside = tall > 9.0 + LINE * len(lines)
        _lines(axes, x + 4.5, y + 13.0 if inside else bottom + 12.0, lines, "left")


def _label(body: str, material: str, room: float) -> list[str]:
    """The label of a body, in two lines where one is wider than the room (points)."""
    text = f"{body}: {material}"
    return [text] if LETTER * len(text) <= room else [f"{body}:", material]


def _lines(axes: Axes, x: float, y: float, lines: Sequence[str], anchor: str) -> None:
    for number, words in enumerate(lines):
        write(axes, "plain", x, y + LINE * number, words, anchor)


def _dimension(axes: Axes, dimension: Dimension, place: Placing, label: str) -> None:
    """A length beside what it measures: above or below it, or to its right."""
    (x1, y1), (x2, y2) = place(*dimension.begin), place(*dimension.end)
    if abs(x2 - x1) < abs(y2 - y1):
        x, ends = x1 + APART, sorted((y1, y2))
        for begin, end in ((x1, y1), (x2, y2)):
            line(axes, "thin", (begin, x + 3.0), (end, end))
        arrow(axes, "measured", (x, x), ends)
        write(axes, "measured", x + 5.0, 0.5 * sum(ends) + 3.0, label, "left")
        return
    is_above = y1 <= ABOVE + 1.0
    y = y1 - APART if is_above else y1 + APART
    for x in (x1, x2):
        line(axes, "thin", (x, x), (y1, y))
    arrow(axes, "measured", (x1, x2), (y, y))
    if is_above:
        write(axes, "measured", min(x1, x2) - 4.5, y + 3.0, label, "right")
    elif LETTER * len(label) > abs(x2 - x1):
        write(axes, "measured", max(x1, x2) + 4.5, y + 9.0, label, "left")
    else:
        write(axes, "measured", 0.5 * (x1 + x2), y + 12.0, label, "center")
