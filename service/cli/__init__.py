"""The command ``whipple``: its commands, what they print, and the work that they do without a service.

The top room: it may import every other.
"""
