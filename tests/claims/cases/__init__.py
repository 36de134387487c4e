"""Examples of the thesis, and laws out of cubes."""

ALSO = ["loads", "contact", "crater-walls"]
