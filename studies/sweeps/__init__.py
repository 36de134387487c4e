"""A sweep: its document, its axes, what it costs, and the runs that it asks for.

``document`` turns YAML or JSON into a checked ``Sweep`` or a list of errors. Called by the service, the reports and
``whipple.run_sweep``.
"""
