"""Offers fitted laws to sweeps."""

from studies.laws.documents import LawReader, OwnLaw


def _read(document: object, path: str) -> OwnLaw:
    from studies.fits.fitted import read_law

    return read_law(document, path)


READER = LawReader("fitted", _read)
