"""A sweep: its document, its axes, what it costs, and the runs that it asks for.

``document`` reads files, ``reading`` turns plain values into the checked fields of a ``Sweep``, or a list of errors.
Called by the service, the reports and ``whipple.run_sweep``.
"""
