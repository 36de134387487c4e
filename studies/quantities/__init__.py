"""Quantities: units at the door, checked parameters, their display, errors of input, measured numbers, recipes, files.

The lowest room of the studies: everything else may import it, and it imports nothing of them.
"""
