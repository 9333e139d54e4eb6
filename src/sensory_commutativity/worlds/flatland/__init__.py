"""Flatland: a one-eyed agent in a two-dimensional room, on pymunk (paper, section III-A).

Importing :mod:`.environment` registers the Gymnasium environment
``SensoryCommutativity/Flatland-v0``; this package itself imports nothing.
"""
