"""Whipple shields at the doors of the service: the command ``shots``, and pages."""
