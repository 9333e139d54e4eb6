"""Training of the models and of their view classifiers."""
