"""gallery.md: the sweeps that ship, a sentence each, and a photograph of the report of those that take seconds.

The photographs were taken in Chromium in November 2026, a section of the last run or the first figure.
"""

from studies.sweeps import examples
from studies.sweeps.document import read_yaml

FOLDER = "gallery"
SHOWN = ("aluminium", "bar", "oblique", "plate", "smoke", "taylor")  # less than a minute on two cores
# Pictures of other pages: file, page and what they show.
OTHERS = (
    ("holes.png", "../README.md", "The laws of `holes` beside the simulation."),
    ("gallery.png", "../README.md", "A perforation and a crater of `holes` and `craters`, with debris at two times."),
    ("debris-cloud.png", "clouds.md", "A debris cloud behind a thin plate."),
    ("plugging.png", "methods.md", "A plug of steel, cut out by damage."),
    ("methods.png", "methods.md", "A perforation by material points and by smoothed particles."),
)


def pages() -> dict[str, str]:
    """gallery.md."""
    parts = [
        "# Gallery\n",
        "The sweeps that ship, in `studies/sweeps/examples/`: copy one and change it. A picture shows the last run in "
        "section, or the first figure of the report. White inside a body is a gap: matter was stretched there until "
        "its particles parted, as in a spall. Those without take minutes; `whipple estimate FILE.yaml` says how "
        "many.\n",
    ]
    for name in examples.names():
        text = examples.text(name)
        title, says = read_yaml(text, name)["title"], text.splitlines()[0].removeprefix("# ")
        parts += [f"## {name}\n"]
        if name in SHOWN:
            parts += [f"![{title}]({FOLDER}/{name}.png)\n"]
        parts += [f"**{title}.** {says}\n"]
    parts += ["## Pictures of other pages\n"]
    for file, page, says in OTHERS:
        parts += [f"[![{says}]({file})]({page})\n", f"{says}\n"]
    return {"gallery.md": "\n".join(parts)}
