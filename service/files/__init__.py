"""Where files live: the data directory, artifacts and their checksums, room on the disk, output folders, lost results.

Imports the records alone.
"""
