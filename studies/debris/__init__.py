"""The view of an impact's debris, which the measurements of clouds and of shields read."""
