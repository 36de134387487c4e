"""The largest diameter of a bar: D of a Taylor bar."""

from studies.measurements import Measurement
from studies.measurements._bar import mushroom_of

MEASUREMENT = Measurement(
    name="mushroom_diameter",
    title="Mushroom diameter",
    unit="m",
    meaning="diameter of the widest layer between particle edges; an edge is the centre of the outermost particle and "
    "half of its present distance to the next one in its row",
    version=2,
    read=mushroom_of,
)
