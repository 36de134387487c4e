"""Decks of MPM3D on the command line."""
