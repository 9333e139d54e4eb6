"""Perceptual distances: how different two images look, by the features of an image classifier."""
