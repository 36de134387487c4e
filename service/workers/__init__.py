"""Computing one attempt: a warm child process, and the supervisor that gives it work, listens and ends it.

``warm_process`` runs in the child; engines call the ``supervisor``.
"""
