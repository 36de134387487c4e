"""The Python client of a service: sweeps, runs, queue and catalogue; requests that survive lost connections; event
streams; a cube opened remotely.

Every room may import it (``whipple.Client``); it imports only records and output folders of the service.
"""
