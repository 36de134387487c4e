"""Answers of laws and shots without a run: the command ``whipple laws``, and ``/v1/laws/evaluate``."""
