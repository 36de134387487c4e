"""An impact: its hole (``hole``) and its crater (``crater``), and the view of both (``view``)."""

from studies.measurements.impact import crater, hole

MEASUREMENT = (*hole.MEASUREMENT, *crater.MEASUREMENT)
