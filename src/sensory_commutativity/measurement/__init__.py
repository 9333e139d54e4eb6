"""Measuring the SCP of every degree of freedom of a world, in one call."""
