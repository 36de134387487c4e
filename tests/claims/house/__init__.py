"""That the house stays one in which a newcomer finds the way."""
