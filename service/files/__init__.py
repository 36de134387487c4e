"""The data directory and its lock, artifacts and their checksums, disk space, output folders, lost results.

Imports the records alone; called by store, workers, queue, API and command line.
"""

SOCKET = "whipple.sock"  # in the data directory: the door of its owner, where the loopback asks for a key
