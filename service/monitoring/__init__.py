"""Metrics for a monitor, at ``/metrics``."""
