"""Pages for people, one module for what belongs together; each works offline, and what scripts add is a convenience."""
