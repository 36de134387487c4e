"""Sections of every run at a few times, and of debris a ``radiograph``.

``runs`` records them, ``reports`` draws them.
"""
