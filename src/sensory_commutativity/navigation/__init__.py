"""What the SCP is good for: learning to navigate with action spaces made from it (paper, section IV-B)."""
