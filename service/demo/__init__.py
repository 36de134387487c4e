"""The examples that ship, computed: ``whipple demo``."""
