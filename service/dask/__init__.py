"""The engine of a cluster, for ``WHIPPLE_ENGINE=tls://HOST:PORT``: ``engine`` speaks with a Dask scheduler, and
``worker`` runs in its workers. Needs the extra ``cluster``.
"""
