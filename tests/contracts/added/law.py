"""A hole that grows in proportion to the thickness of the plate."""

from studies.laws import Code, Law, Limit, Range


def hole_ratio(thickness_ratio):
    """D/d over t/d.

    >>> hole_ratio(0.5)
    1.5
    """
    return 1.0 + thickness_ratio


LAW = Law(
    name="proportional",
    title="Proportional to the thickness",
    quantity="hole_diameter",
    equation="D/d = 1 + t/d",
    source="made up for a contract test",
    confidence="user",
    range=Range(Limit(Code.STATED, "user", names=("any plate",))),
    ratio=lambda shot, variant: hole_ratio(shot.thickness_ratio),
)
