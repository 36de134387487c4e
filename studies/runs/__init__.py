"""A run: one point of a sweep, its identity, its computation, its checkpoints and its log.

``run`` says what is asked and needs no solver; ``execution`` computes it and is imported only by processes that solve.
``remeasure`` reads stored final states again.
"""
