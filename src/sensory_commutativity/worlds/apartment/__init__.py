"""A robot in a furnished apartment, on PyBullet (paper, section III-B)."""
