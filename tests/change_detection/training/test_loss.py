"""The loss of the two-mask models by hand."""

from __future__ import annotations

import pytest
import torch

from sensory_commutativity.change_detection.training.loss import dice_loss, mask_loss


def test_losses_by_hand():
    masks = torch.zeros(1, 2, 8, 8)
    masks[0, 0, :2] = 1.0
    assert dice_loss(200 * masks - 100, masks).item() == pytest.approx(0.0, abs=1e-6)
    nothing = torch.full_like(masks, -100.0)  # right for the empty mask
    assert dice_loss(nothing, masks).item() == pytest.approx((1 - 10 / 26) / 2)
    everything = torch.full_like(masks, 100.0)
    expected = (1 - 42 / 90 + 1 - 10 / 74) / 2
    assert dice_loss(everything, masks).item() == pytest.approx(expected)

    # later refinements count more, and the Dice loss only where something moved
    masks = torch.zeros(1, 2, 8, 8)
    good, bad = torch.full((1, 2, 8, 8), -5.0), torch.full((1, 2, 8, 8), 5.0)
    no, yes = torch.tensor([False]), torch.tensor([True])
    assert mask_loss([bad, good], masks, no) < mask_loss([good, bad], masks, no)
    assert mask_loss([bad], masks, yes) > mask_loss([bad], masks, no)
