"""Thin endpoints, one file for each kind of resource: parse, call one function, return.

To add one: a module here with a ``router``, and its name in ``app.GUARDED``. Errors are raised as exceptions that carry
their meaning; ``service.api.errors`` has the table that maps them to statuses.
"""
