"""Values and their display: quantities with units, checked parameters, presets, results, least squares, errors, files.

The lowest room of the studies: everything else may import it, and it imports nothing of them.
"""
