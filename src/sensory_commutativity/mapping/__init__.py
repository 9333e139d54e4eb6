"""Mapping what cannot be moved: where in an apartment the SCP is low (paper, section IV-A)."""
