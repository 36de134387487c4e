"""A run: one point of a sweep, its identity, its computation, its checkpoints and its log.

``run`` resolves and names a run and needs no solver; ``execution`` computes it (with ``observer`` and ``run_log``) and
is imported only by processes that solve. ``remeasure`` reads stored final states again.
"""
