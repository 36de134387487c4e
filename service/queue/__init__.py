"""The queue at work: dispatcher, term of its leader, attempts in flight, their results, and garbage collection.

The rows of the store are the truth; an engine of ``execution`` is asked to compute. Called by the interface and the
command line, never by the store.
"""
