"""The Python client of a service: sweeps, runs, queue and catalogue; requests that survive lost connections; event
streams; a cube opened remotely.

Anybody may import it (``whipple.Client``); of the service it imports records and output folders only.
"""
