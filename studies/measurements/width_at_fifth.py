"""How wide a bar is a fifth of its initial length above the impact face: W of a Taylor bar, Ma (2005), figure 2.3."""

from studies.measurements import Measurement, Reading
from studies.measurements._bar import BarView, width_of

HEIGHT = 0.2  # of the initial length: Ma (2005), section 2.3.2


def _read(view: BarView) -> Reading:
    return width_of(view, HEIGHT)


MEASUREMENT = Measurement(
    name="width_at_fifth",
    title="Width at a fifth of the length",
    unit="m",
    meaning="diameter between particle edges at 0.2 of the initial length above the impact face",
    version=1,
    read=_read,
)
