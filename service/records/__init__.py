"""Records that every room of the service shares: states and records of the queue, settings, timings, signals, logs.

Pure: no database, no engine, no HTTP. The lowest room of the service; every other room may call it.
"""
