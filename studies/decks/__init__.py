"""Decks of MPM3D: reads an input file into a ``Deck`` (``reader``), and makes a problem of it (``problem``)."""
