"""Examples of the thesis, and laws out of cubes."""
