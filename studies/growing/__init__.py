"""Later ends for runs that were still growing."""
