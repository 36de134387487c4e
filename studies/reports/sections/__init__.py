"""Sections of the spine of reports, a file each, which offers a ``SECTION``: its record and where it stands.

What computes a part lies beside it in a module whose name begins with an underscore, or in a room that does.
"""
