"""The Python client of a service (``whipple.Client``), and the commands that send requests: sweeps, runs, queue and
catalogue; requests that survive lost connections; event streams; a cube opened remotely.
"""
