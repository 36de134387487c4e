"""Records that every room of the service shares: states, moves and rows of the queue, and an expanded sweep.

Pure: no database, no engine, no HTTP. The lowest room of the service; every other room may call it.
"""
