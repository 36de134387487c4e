"""Events as they happen, as server-sent events, and past ones as pages."""
