"""A robot in a furnished apartment, simulated by PyBullet (paper, section III-B)."""
