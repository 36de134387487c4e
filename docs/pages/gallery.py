"""gallery.md: the sweeps that ship, a sentence each, and a photograph of the report of those that take seconds.

The photographs were taken in Chromium in November 2026, a section of the last run or the first figure.
"""

from docs.pages import in_markdown
from studies.sweeps import examples
from studies.sweeps.document import read_yaml

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
    texts = {name: examples.text(name) for name in examples.names()}
    sweeps = [
        (name, read_yaml(text, name)["title"], text.splitlines()[0].removeprefix("# ")) for name, text in texts.items()
    ]
    return {"gallery.md": in_markdown("gallery", sweeps=sweeps, shown=SHOWN, others=OTHERS)}
