"""Line charts of live pages: their points, and the image that a child process draws of them as of a report's."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from hashlib import sha256
from urllib.parse import urlencode

from fastapi import Request, Response
from markupsafe import Markup

from service.api.dependencies import read_posted
from service.api.reading import Posted, drawn_chart
from service.records.jobs import NotFound

MOST_LINES = 8  # in as many colours
KEPT_SECONDS = 86400  # by a browser: an address names its content
WIDTH, HEIGHT = 480, 330  # px of an image until it is there; its height then follows its legend


@dataclass(frozen=True)
class ChartLine:
    """Points in SI; None where there is none."""

    label: str
    x: Sequence[float | None]
    y: Sequence[float | None]
    uncertainty: Sequence[float | None] = ()  # half lengths of error bars


@dataclass(frozen=True)
class Chart:
    """Lines over a common abscissa; each axis has a name, a label and an SI unit."""

    title: str
    x: tuple[str, str, str | None]
    y: tuple[str, str, str | None]
    lines: Sequence[ChartLine]
    marked: bool = False  # whether each point has a mark

    @property
    def is_empty(self) -> bool:
        return all(value is None for line in self.lines for value in line.y)

    def document(self) -> bytes:
        """The chart as JSON, with the most lines that are drawn, spread evenly over all."""
        count = len(self.lines)
        lines = [self.lines[k * count // MOST_LINES] for k in range(MOST_LINES)] if count > MOST_LINES else self.lines
        return json.dumps(asdict(self) | {"lines": [asdict(line) for line in lines]}).encode()

    def image(self, path: str, query: Mapping[str, str | int]) -> Markup:
        """The image that a path gives, whose address changes with its content; nothing where no point has a value."""
        if self.is_empty:
            return Markup("")
        address = f"{path}?{urlencode({**query, 'content': sha256(self.document()).hexdigest()[:16]})}"
        tag = Markup('<img class="chart" src="{}" alt="{}" width="{}" height="{}" loading="lazy">{}')
        more = len(self.lines) - MOST_LINES
        note = Markup("<p>{} of {} lines are drawn.</p>").format(MOST_LINES, len(self.lines)) if more > 0 else ""
        return tag.format(address, f"{self.title} against {self.x[1]}", WIDTH, HEIGHT, note)


async def drawn(request: Request, chart: Chart) -> Response:
    """A chart as SVG; raises NotFound for an empty one, TooManyRequests where no child process is free in time."""
    if chart.is_empty:
        raise NotFound("values to draw of", chart.title)
    svg = await read_posted(request, Posted("application/json", chart.document(), 0), drawn_chart)
    return Response(svg, media_type="image/svg+xml", headers={"Cache-Control": f"private, max-age={KEPT_SECONDS}"})
