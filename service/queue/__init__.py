"""The queue at work: the dispatcher, its term as leader, verification and registration of results, garbage collection.

The rows of the store are the truth; an engine of ``service.execution`` is asked to compute. The API and the command
line call this room; the store never does.
"""
