"""Learning to navigate with action spaces derived from the SCP (paper, section IV-B)."""
