"""The second look at what moved, with a made-up model that writes down what it is shown."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from sensory_commutativity.masks.second_look import WAYS, look_again


class Brightness:
    """Sees what is bright."""

    def __init__(self):
        self.shown: list[torch.Tensor] = []

    def __call__(self, pictures):
        self.shown.append(pictures)
        return pictures.mean(2)


def smooth(n: int, side: int = 128) -> torch.Tensor:
    waves = torch.sin(torch.linspace(0, 3, side))
    return (waves[:, None] * waves[None, :]).expand(n, 2, 3, side, side) * torch.tensor([1.0, 0.5])[None, :, None, None, None]


def changed(n: int, side: int, rows: slice, columns: slice) -> np.ndarray:
    found = np.zeros((n, side, side), bool)
    found[:, rows, columns] = True
    return found


@pytest.mark.parametrize(("columns", "sides"), [(slice(3, 20), 128), (slice(3, 100), 64)])
def test_another_scale_shows_the_same(columns, sides):
    see, pictures = Brightness(), smooth(2)
    logits = look_again(see, pictures, changed(2, 128, slice(100, 120), columns), 64)
    assert torch.allclose(logits, pictures.mean(2), atol=0.02)
    assert len(see.shown) == 2 * len(WAYS) and see.shown[-1].shape[-1] == sides


def test_what_is_small_is_seen_nearer():
    see, pictures = Brightness(), torch.zeros(1, 2, 3, 128, 128)
    pictures[0, 0, :, 10:20, 118:128] = 1.0
    logits = look_again(see, pictures, changed(1, 128, slice(10, 20), slice(118, 128)), 64)
    assert float(see.shown[len(WAYS)][0, 0].mean()) == pytest.approx(4 * float(pictures[0, 0].mean()), rel=0.05)
    assert logits[0, 0, 12:18, 120:126].min() > 0.95 and not logits[0, 1].any()


def test_pictures_that_cannot_be_halved_are_seen_as_they_are():
    see = Brightness()
    look_again(see, smooth(1, 64), changed(1, 64, slice(0, 64), slice(0, 64)), 64)
    assert len(see.shown) == len(WAYS)


def test_pairs_of_either_kind_keep_their_places():
    pictures = torch.arange(3.0)[:, None, None, None, None].expand(3, 2, 3, 128, 128)
    where = np.concatenate([changed(1, 128, slice(0, 9), slice(0, 9)), changed(1, 128, slice(0, 128), slice(0, 9)), np.zeros((1, 128, 128), bool)])
    assert torch.allclose(look_again(Brightness(), pictures, where, 64), pictures.mean(2), atol=1e-5)
