"""What the templates of pictures call: drawings of a report's document, from the files of its runs' sections."""

from collections.abc import Iterable, Mapping

from markupsafe import Markup
from pydantic import TypeAdapter

from studies.pictures.section import DrawnSetUp, Pictures
from studies.pictures.shown import THUMBNAIL_FIELDS, first_of_kinds
from studies.pictures.sketches import setup_sketch
from studies.quantities.parameters import Plain
from studies.reports.drawing.sections import Gallery, colour_keys
from studies.reports.page import Node, bare
from studies.reports.picture import Picture
from studies.reports.section import Files, Words

PICTURE, PICTURES, SETUP = TypeAdapter(Picture), TypeAdapter(Pictures), TypeAdapter(DrawnSetUp)


def words(report: Mapping[str, Plain], files: Files) -> Words:
    """The functions by their names; ``files`` are those of sections by run id."""
    ids = (str(bare(run.id)) for run in (Node(report).runs.runs if "runs" in report else ()))
    gallery = Gallery({number: files[id] for number, id in enumerate(ids) if id in files})

    def draw(run: Node, picture: Node, *, full: bool, place: str = "") -> Markup:
        number = int(str(bare(run)))
        return gallery.picture(number, PICTURE.validate_python(bare(picture)), full=full, place=place)

    return {
        "draw": draw,
        "opening": _opening,
        "thumbnails": _thumbnails,
        "setup": lambda document: setup_sketch(SETUP.validate_python(bare(document))),
        "colour_keys": lambda pictures: colour_keys(first_of_kinds(PICTURES.validate_python(bare(pictures)))),
    }


def cover(report: Mapping[str, Plain], files: Files) -> tuple[str, Markup, Markup] | None:
    """The picture beside the opening figure, large and small, behind what it shows: the end of a run, or the set-up."""
    pictures = Node(report)._part("pictures")
    if opening := _opening(pictures):
        run, picture = opening
        draw = words(report, files)["draw"]
        large, small = (Markup(draw(run.run, picture, full=full)) for full in (True, False))
        return f"{bare(run.title)}: {bare(picture.label)}".removeprefix(": "), large, small
    if bare(pictures.setup) is None:
        return None
    drawn = SETUP.validate_python(bare(pictures.setup))
    return drawn.alt, setup_sketch(drawn), setup_sketch(drawn)


def _opening(pictures: Node) -> tuple[Node, Node] | None:
    """The run in full size at the end of the axes, and the picture of its end; None without any."""
    shown = [
        (run, picture)
        for run in pictures.runs
        for picture in run.pictures
        if bare(run.full) and bare(picture.kind) == "end" and not bare(picture.missing)
    ]
    last = [pair for pair in shown if pair[0] is shown[-1][0]]
    return last[0] if last else None


def _thumbnails(pictures: Iterable[Node], kind: str) -> list[Node]:
    """The pictures of a run that its thumbnails show."""
    mine = (picture for picture in pictures if bare(picture.kind) == kind)
    return [picture for picture in mine if bare(picture.missing) or bare(picture.field) == THUMBNAIL_FIELDS[kind]]
