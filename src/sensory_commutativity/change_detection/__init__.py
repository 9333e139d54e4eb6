"""Detect what moved between two pictures, as one mask per picture (paper, section IV-A).

:mod:`.predictor` applies a model to pairs of pictures; :mod:`.tta` and
:mod:`.models.view_classifier` refine its masks, and :mod:`.decision` turns them into an outcome.
:mod:`.training` trains the models, on pairs that :mod:`.simulated` renders.
"""
