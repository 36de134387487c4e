"""Pages for people: a feature that takes part in the interface by its routes (``service.pages.routes``).

Each page works offline, and what scripts add is a convenience. Single pages are in the folder ``pages``; modules that
child processes import (``forms``, ``computed``) load neither the web framework nor the store.
"""
