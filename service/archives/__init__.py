"""Everything of a sweep in one file."""
