"""Values at the door and how they are shown: quantities with units, checked parameters, presets, findings, files.

The lowest room of the studies: everything else may import it, and it imports nothing of them.
"""
