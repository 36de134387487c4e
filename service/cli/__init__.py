"""The command ``whipple``: its commands, their output, and the work that they do without a service.

It may import every room below, and only features, the package ``whipple`` and ``python -m service`` import it.
"""
