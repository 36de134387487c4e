"""Computing one attempt: a warm process, and the supervisor that sends it the attempt, receives messages and ends it.

``attempt`` has the records that engines and the queue exchange, ``timings`` their intervals and deadlines.
``warm_process`` runs in the child; engines call the ``supervisor`` with a ``Slot``.
"""
