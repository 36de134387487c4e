"""measurements.md: the definition of every measurement that ships, with a drawing.

The drawings are files of docs/drawings, written by hand: polygons, dashed lines, dimensions and names.
"""

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
    parts = [
        "# Measurements\n",
        "Numbers that are read off the state of a run. Each carries the parts of its uncertainty and the flags that "
        "speak against it. Its version rises when its definition changes; stored states are then measured again "
        "([how](how-to.md#measure-again)). An edge stands where a density, averaged over a cell, falls to half of its "
        "undisturbed value, unless the definition says otherwise.\n",
    ]
    for scenario, (file, title, caption) in SCENARIOS.items():
        parts += [f"## {title}\n", f"![{title}: {caption}](drawings/{file}.svg)\n"]
        for name in scenarios.load(scenario).measurements:
            each = measurements.load(name)
            unit = "ratio" if each.unit == "1" else each.unit
            parts += [
                f"**`{name}`** ({unit}, version {each.version}): {each.title}. "
                f"{each.meaning[0].upper()}{each.meaning[1:]}.\n"
            ]
    return {"measurements.md": "\n".join(parts)}
