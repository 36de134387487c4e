"""Films of runs at the doors of the service: files that are made of them, their addresses, and ``whipple export``."""
