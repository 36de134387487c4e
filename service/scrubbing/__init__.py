"""Comparison of all stored files with their digests, round and round: a keeper of the queue's leader."""
