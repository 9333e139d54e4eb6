"""Models that see what moved between two pictures."""
