"""measurements.md: the definition of every measurement that ships, with a drawing.

The drawings are files of docs/drawings, written by hand: polygons, dashed lines, dimensions and names.
"""

from docs.pages import in_markdown
from studies import measurements, scenarios

SCENARIOS = {
    "thin_plate": ("perforation", "A hole in a thin plate", "section along the line of flight"),
    "debris_cloud": ("debris-cloud", "A debris cloud", "section along the line of flight, which points down"),
    "thick_plate": ("crater", "A crater in a thick block", "section along the line of flight"),
    "taylor_bar": ("taylor-bar", "A Taylor bar", "the bar at the end, on its wall"),
    "elastic_bar": ("elastic-bar", "An elastic bar", "push of the wall against time, and where the energy went"),
    "plate_impact": ("plate-impact", "A plate impact", "pressure across flyer and target before waves return"),
    "whipple_shield": ("shield", "A Whipple shield", "section along the line of flight, which points down"),
    "plugging": ("plugging", "Plugging of a plate", "section along the line of flight, which points down"),
    "deck": ("deck", "A deck of MPM3D", "all particles on the grid, whatever their bodies are"),
}  # fmt: skip


def pages() -> dict[str, str]:
    """measurements.md."""

    def measured(scenario: str) -> list[measurements.Measurement]:
        return [measurements.load(name) for name in scenarios.load(scenario).measurements]

    return {"measurements.md": in_markdown("measurements", scenarios=SCENARIOS, measured=measured)}
