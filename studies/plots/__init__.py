"""Two cubes compared, in figures and in a table of their differences."""
