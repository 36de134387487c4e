"""Laws to be fitted, and fitted ones: ``forms`` whose constants a fit finds, ``fitted`` for the next sweep."""
