"""Statistical tests and intervals. Nothing here knows what the numbers measure."""
