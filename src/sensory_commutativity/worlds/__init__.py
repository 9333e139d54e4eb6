"""Worlds in which the experiment is played. No other package imports a physics engine."""
