"""A drawing as an image with an address of its own, for pages that allow no styles inside: it reads in light and dark.

Its colours are those of a report (``templates/report.css``).
"""

import base64
import re
from collections.abc import Iterator
from functools import cache
from importlib.resources import files

from markupsafe import Markup

# Canvases are those of browsers.
LIGHT = "svg { --page: #fff; font-family: Helvetica, Arial, sans-serif } "
LABELS = (
    ".measured text, .small text { paint-order: stroke; stroke: var(--page); stroke-width: 2.2px } "
    ".of-run .measured text { stroke: var(--c-ffffff, #fff) }"
)


@cache
def picture_style() -> str:
    """The rules of a report's style sheet about its pictures, for the canvas of a browser."""
    sheet = files("studies.reports").joinpath("templates", "report.css").read_text(encoding="utf-8")
    dark = " ".join(f"svg{kind} {rule}" for kind, rule in re.findall(r"\.picture(\.of-run)? (\{ --c-[^}]*\})", sheet))
    return LIGHT + f"@media (prefers-color-scheme: dark) {{ {dark} svg {{ --page: #16181c }} }} " + LABELS


def as_image(drawing: Markup) -> str:
    """The address of an image of one drawing, its content inside."""
    [image] = as_images(drawing)
    return image


def as_images(drawings: Markup) -> Iterator[str]:
    """The addresses of the images of drawings that stand one behind another."""
    for content in as_files(drawings):
        yield f"data:image/svg+xml;base64,{base64.b64encode(content.encode()).decode()}"


def as_files(drawings: Markup) -> Iterator[str]:
    """Contents of SVG files, one for each of the drawings that stand one behind another."""
    for inside in re.findall(r"<svg class=\"picture.*?</svg>", drawings, re.DOTALL):
        names = 'xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink"'
        size = re.search(r'viewBox="0 0 ([\d.]+) ([\d.]+)"', inside)
        assert size
        width, height = (float(number) / 0.75 for number in size.groups())
        text = inside.replace("<svg", f'<svg {names} width="{width:.0f}" height="{height:.0f}"', 1)
        yield text.replace(">", f"><style>{picture_style()}</style>", 1)
