"""The command ``whipple``: its commands, their output, and the work that they do without a service.

The top room: it may import every other, and only the package ``whipple`` and ``python -m service`` import it.
"""
