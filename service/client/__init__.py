"""A service from Python: its client, the connection that sends again, server-sent events, and a cube opened remotely.

What ``whipple.Client`` is; imports nothing of the service but output folders.
"""
