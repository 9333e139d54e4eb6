"""predict_change(): arrays and files, with the predictor that belongs to the package."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image

from sensory_commutativity import ArgumentError, UserError, predict_change


@pytest.fixture(scope="module")
def pictures() -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(0)
    coarse = Image.fromarray(rng.integers(60, 200, (8, 10, 3), np.uint8))
    before = np.asarray(coarse.resize((160, 128), Image.Resampling.BICUBIC))
    after = before.copy()
    after[40:80, 50:100] = (220, 20, 20)
    return before, after


def test_the_same_picture_twice_is_identical(pictures) -> None:
    change = predict_change(pictures[0], pictures[0])
    assert change.outcome == "identical" and not change.masks.any()
    assert change.masks.shape == (2, 128, 160)


def test_what_appeared_is_outlined_from_arrays_and_files_alike(pictures, tmp_path) -> None:
    change = predict_change(*pictures)
    assert change.outcome == "moved"
    truth = np.zeros((128, 160), bool)
    truth[40:80, 50:100] = True
    second = change.masks[1]
    assert (second & truth).sum() / (second | truth).sum() > 0.5
    files = [tmp_path / "before.png", tmp_path / "after.png"]
    for file, picture in zip(files, pictures, strict=True):
        Image.fromarray(picture).save(file)
    again = predict_change(*files)
    assert again.outcome == "moved" and np.array_equal(again.masks, change.masks)


@pytest.mark.parametrize(
    ("before", "message"),
    [
        (np.zeros((128, 160, 3)), "before: expected an RGB picture, .* got float64"),
        (np.zeros((128, 160), np.uint8), "before: .* got uint8"),
        (None, "before: .* got NoneType"),
    ],
)
def test_what_is_no_picture_is_refused(pictures, before, message) -> None:
    with pytest.raises(ArgumentError, match=message):
        predict_change(before, pictures[1])
    with pytest.raises(UserError):
        predict_change(pictures[0], pictures[1][:100])
