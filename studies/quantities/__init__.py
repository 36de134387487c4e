"""The lowest room: units, checked parameters, display, errors of input, measured numbers, recipes, files."""
