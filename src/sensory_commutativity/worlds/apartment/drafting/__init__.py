"""A first description of a robot from its URDF alone, and trials of a description."""
