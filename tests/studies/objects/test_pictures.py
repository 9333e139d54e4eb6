"""Example pictures with the outlines of their masks."""

from __future__ import annotations

import json

import matplotlib.pyplot as plt
import numpy as np
import pytest

from sensory_commutativity.storage.arrays import pack_masks, write_arrays
from sensory_commutativity.studies.objects.figures.mask_dataset import mask_dataset
from sensory_commutativity.studies.objects.pictures import draw_examples, read_examples

SIZE = 12
IDENTICAL, DIFFERENT, MOVED = range(3)


@pytest.fixture(scope="module")
def examples_file(tmp_path_factory):
    """Two examples of one test set, one of another, and a training pair."""
    path, rng = tmp_path_factory.mktemp("examples") / "mask_examples.h5", np.random.default_rng(0)
    masks = np.zeros((3, 2, SIZE, SIZE), bool)
    masks[0, :, 3:6, 4:9] = True
    probabilities = np.full((3, 2, SIZE, SIZE), 200, np.uint8)
    probabilities[:, :, 6:] = 50
    content = dict(
        dataset_pictures=rng.integers(256, size=(1, 2, SIZE, SIZE, 3), dtype=np.uint8),
        dataset_masks=pack_masks(masks[:1]),
        dataset_outcome=np.array([MOVED], np.int8),
        pictures=rng.integers(256, size=(3, 2, SIZE, SIZE, 3), dtype=np.uint8),
        masks=pack_masks(masks),
        probabilities=probabilities,
        outcome=np.array([MOVED, IDENTICAL, DIFFERENT], np.int8),
        predicted=np.array([MOVED, IDENTICAL, DIFFERENT], np.int8),
        overlap=np.array([0.5, np.nan, np.nan]),
    )
    test_sets = ["as-trained", "as-trained", "all-other"]
    write_arrays(path, "mask_examples", content, {"test_sets": json.dumps(test_sets)})
    return path, masks


def test_masks_are_unpacked(examples_file):
    path, masks = examples_file
    arrays, test_sets = read_examples([path])
    assert np.array_equal(arrays["masks"], masks) and arrays["masks"].dtype == bool
    assert np.array_equal(arrays["dataset_masks"], masks[:1])
    assert test_sets == ["as-trained", "as-trained", "all-other"]


def test_each_test_set_has_a_row_and_outlines_show_what_moved(examples_file):
    figure = draw_examples(read_examples([examples_file[0]]), ["as-trained", "all-other"])
    grid = np.array(figure.axes).reshape(4, 2)
    assert [[axes.axison for axes in row] for row in grid] == [[True] * 2] * 2 + [[True, False]] * 2
    outlines = [[len(axes.collections) for axes in row] for row in grid]
    assert outlines == [[2, 0], [2, 0], [0, 0], [0, 0]]  # true and predicted
    titles = [axes.get_title() for axes in grid[::2].flat]
    assert titles == [
        "as trained\ntrue: moved, IoU 0.50\npredicted: moved",
        "as trained\ntrue: identical\npredicted: identical",
        "all other\ntrue: different\npredicted: different",
        "",
    ]
    plt.close(figure)


def test_training_pairs_are_drawn_with_their_masks(examples_file, default_config):
    path, masks = examples_file
    figure = mask_dataset.compute({"mask_examples": [path]}, default_config)
    pictures = [axes.images[0].get_array() for axes in figure.axes]
    dataset = read_examples([path]).arrays["dataset_pictures"][0]
    for drawn, expected in zip(
        pictures, (dataset[0], masks[0, 0], dataset[1], masks[0, 1]), strict=True
    ):
        assert np.array_equal(drawn, expected)
    plt.close(figure)
