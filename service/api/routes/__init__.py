"""Thin endpoints: parse, call one function, return. One file a kind of thing.

How to add one: a module here with a ``router``, and a line in ``app.ROUTERS``. Errors are raised as
exceptions that carry their meaning; ``service.api.errors`` has the one table that makes them statuses.
"""
