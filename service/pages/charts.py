"""Line charts of live pages: their points, and the image that a child process draws of them as of a report's."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from hashlib import sha256
from urllib.parse import urlencode

from markupsafe import Markup

from studies.reports.figure import Scale, Series

MOST_LINES = 8  # in as many colours
WIDTH, HEIGHT = 480, 330  # px of an image until it is there; its height then follows its legend


@dataclass(frozen=True)
class Chart:
    """Lines over a common abscissa."""

    title: str
    x: Scale
    y: Scale
    lines: Sequence[Series]  # of the kind ``quantity`` with a mark for each point, else ``history``

    @property
    def is_empty(self) -> bool:
        return all(value is None for line in self.lines for value in line.y)

    def drawn_part(self) -> "Chart":
        """The chart with the most lines that are drawn, spread evenly over all."""
        count = len(self.lines)
        if count <= MOST_LINES:
            return self
        return replace(self, lines=[self.lines[k * count // MOST_LINES] for k in range(MOST_LINES)])

    def image(self, path: str, query: Mapping[str, str | int | list[str]]) -> Markup:
        """The image that a path gives, whose address changes with its content; nothing where no point has a value."""
        if self.is_empty:
            return Markup("")
        content = sha256(json.dumps(asdict(self)).encode()).hexdigest()[:16]
        address = f"{path}?{urlencode({**query, 'content': content}, doseq=True)}"
        tag = Markup('<img class="chart" src="{}" alt="{}" width="{}" height="{}" loading="lazy">{}')
        more = len(self.lines) - MOST_LINES
        note = Markup("<p>{} of {} lines are drawn.</p>").format(MOST_LINES, len(self.lines)) if more > 0 else ""
        return tag.format(address, f"{self.title} against {self.x.label}", WIDTH, HEIGHT, note)
