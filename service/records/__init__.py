"""What every part of the service knows: states and records of the queue, settings, version, signals, logging.

Pure: no database, no engine, no HTTP. The lowest room of the service.
"""
