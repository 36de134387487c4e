"""Methods side by side in reports: what the method does to an answer, beside the bars of both."""
