"""Seeing what moved: from two pictures, whether nothing, everything or some things changed, and which (paper, section IV-A)."""
