"""The report says which law to trust, and how sure that is."""
