"""The length of a bar."""

from studies.measurements import Measurement
from studies.measurements._bar import length_of

MEASUREMENT = Measurement(
    name="final_length",
    title="Length of the bar",
    unit="m",
    meaning="distance between the lowest and the highest particle edge along the bar; an edge is the centre of the "
    "outermost particle and half of its present distance to the next one in its row",
    version=2,
    read=length_of,
)
