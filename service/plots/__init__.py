"""Figures of cubes as files, on the command line."""
