"""Prediction of picture files."""

from __future__ import annotations

import re
import zlib
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from sensory_commutativity.change_detection.predict import (
    predict_files,
    read_picture,
    read_pictures,
    resize_to_training,
)
from sensory_commutativity.change_detection.predictor import (
    MaskPredictor,
    Prediction,
    PredictorError,
)
from sensory_commutativity.errors import UserError
from tests.change_detection.examples import make_pairs

PAPER_RAFT = Path(__file__).resolve().parents[2] / "results/paper/models/masks/raft.predictor"


@pytest.fixture
def predictor(tmp_path):
    path = tmp_path / "difference.predictor"
    MaskPredictor("difference", None).save(path, {})
    return path


def with_huge_size(png: bytes) -> bytes:
    """The PNG file with a header that claims 40,000 x 40,000 pixels."""
    start = png.index(b"IHDR")
    header = b"IHDR" + (40_000).to_bytes(4, "big") * 2 + png[start + 12 : start + 17]
    return png[:start] + header + zlib.crc32(header).to_bytes(4, "big") + png[start + 21 :]


def test_files_that_cannot_be_predicted_are_refused(predictor, tmp_path):
    second = make_pairs(3).pictures[2, 1]
    for name, picture in (("a", second), ("tiny", second[:40]), ("small", second[:64])):
        Image.fromarray(picture).save(tmp_path / f"{name}.png")
    whole = (tmp_path / "a.png").read_bytes()
    (tmp_path / "text.png").write_text("no picture")
    (tmp_path / "damaged.png").write_bytes(whole[:60] + bytes(len(whole) - 60))
    (tmp_path / "huge.png").write_bytes(with_huge_size(whole))
    for first, second, message in (
        ("a", "text", "cannot be read as a picture"),
        ("a", "damaged", "cannot be read as a picture"),
        ("a", "huge", "exceeds limit"),
        ("a", "missing", "no such file"),
        ("tiny", "tiny", "40 x 128 pixels; both sides must have at least 64"),
        ("a", "small", "different sizes, 128 x 128 and 64 x 128"),
    ):
        paths = (tmp_path / f"{name}.png" for name in (first, second))
        with pytest.raises(PredictorError, match=message):
            predict_files(*paths, predictor, tmp_path / "out.png")


def test_pictures_are_scaled_to_the_size_of_the_training():
    for sides, scaled in (
        ((128, 128), (128, 128)),
        ((480, 640), (128, 160)),
        ((3000, 2000), (192, 128)),
        ((64, 300), (128, 608)),
    ):
        ramp = np.linspace(0, 255, sides[1]).astype(np.uint8)
        resized = resize_to_training(np.tile(ramp[:, None], (sides[0], 1, 3)))
        assert resized.shape == (*scaled, 3) and resized.dtype == np.uint8
        assert np.abs(resized[0, :, 0] - np.linspace(0, 255, scaled[1])).max() < 4


def test_masks_of_large_pictures_are_outlined_where_they_are(predictor, tmp_path, monkeypatch):
    def predict(self, *pictures):
        assert all(picture.shape == (128, 160, 3) for picture in pictures)
        probabilities = np.zeros((2, 128, 160), np.float32)
        probabilities[0, 32:64, 40:80] = 1
        return Prediction("moved", probabilities)

    monkeypatch.setattr(MaskPredictor, "predict", predict)
    path, out = tmp_path / "a.png", tmp_path / "out.png"
    Image.new("RGB", (1280, 1024)).save(path)
    said = predict_files(path, path, predictor, out)
    assert said.startswith("moved") and "0 in a.png" in said
    drawn = np.asarray(Image.open(out))
    assert drawn.shape == (1024, 2560, 3)
    rows, columns = np.nonzero(drawn.any(2))
    width = 8  # of the line around rows 256 to 512 and columns 320 to 640
    assert (rows.min(), rows.max() + 1) == (256 - width, 512 + width)
    assert (columns.min(), columns.max() + 1) == (320 - width, 640 + width)


def test_the_trained_predictor_of_the_repository_finds_what_moved(tmp_path):
    rng = np.random.default_rng(4)
    wall = np.linspace(90, 160, 400)[:, None, None] * np.array([1.0, 0.9, 0.8])
    empty = np.tile(wall, (1, 400, 1))
    empty[260:] = (120, 90, 60)  # a table
    first, second = empty.copy(), empty.copy()
    first[200:300, 60:150] = second[200:300, 240:330] = (200, 40, 40)
    for name, picture in (("first", first), ("second", second), ("repeated", first)):
        noisy = np.clip(picture + rng.normal(0, 2, picture.shape), 0, 255)
        Image.fromarray(noisy.astype(np.uint8)).save(tmp_path / f"{name}.png")
    out = tmp_path / "out.png"
    same, moved = (
        predict_files(tmp_path / "first.png", tmp_path / f"{name}.png", PAPER_RAFT, out)
        for name in ("repeated", "second")
    )
    assert same == f"identical: the same view, and nothing in it moved; see {out}"
    assert moved.startswith("moved: ") and moved.endswith(f"; see {out}")
    assert Image.open(out).size == (800, 400)
    pixels = [int(number) for number in re.findall(r"(\d+) (?:pixels )?in", moved)]
    assert len(pixels) == 2
    assert all(7_000 < n < 11_500 for n in pixels), moved  # the object has 9,000


def grey_picture(seed: int = 0) -> np.ndarray:
    """A grey picture of 64 x 80 pixels in [0, 1] that uses the whole range."""
    ramp = np.linspace(0, 1, 80)[None, :] * np.linspace(0.2, 1, 64)[:, None]
    return np.clip(ramp + np.random.default_rng(seed).normal(0, 0.02, ramp.shape), 0, 1) / 1.0


def test_pictures_of_any_depth_are_scaled_by_their_range(tmp_path):
    grey = grey_picture()
    grey[0, 0], grey[0, 1] = 0.0, 1.0
    depths = {
        "8.png": (grey * 255).round().astype(np.uint8),
        "12.png": (grey * 4095).round().astype(np.uint16),
        "16.png": (grey * 65535).round().astype(np.uint16),
        "float.tiff": grey.astype(np.float32),
        "float-255.tiff": (grey * 255).astype(np.float32) + np.float32(1e-4) * (grey < 0.5),
    }
    for name, pixels in depths.items():
        Image.fromarray(pixels).save(tmp_path / name)
        read = read_picture(tmp_path / name)
        assert read.shape == (64, 80, 3) and read.dtype == np.uint8
        assert np.abs(read[..., 0] - grey * 255).max() <= 1.0, name


def test_both_pictures_of_a_pair_are_scaled_alike(tmp_path):
    grey = grey_picture() * 0.9
    for name, factor in (("a.png", 20_000), ("b.png", 30_000), ("dark.png", 500)):
        Image.fromarray((grey * factor).astype(np.uint16)).save(tmp_path / name)
    first, second = read_pictures(tmp_path / "a.png", tmp_path / "b.png")
    assert second.mean() / first.mean() == pytest.approx(1.5, rel=0.02)
    with pytest.raises(UserError, match="of different depths"):
        read_pictures(tmp_path / "a.png", tmp_path / "dark.png")
    Image.fromarray(np.full((64, 80), np.nan, np.float32)).save(tmp_path / "nan.tiff")
    with pytest.raises(UserError, match="not finite"):
        read_picture(tmp_path / "nan.tiff")


def test_an_input_is_never_overwritten_and_an_output_only_if_asked(predictor, tmp_path):
    first, second, link = (tmp_path / name for name in ("a.png", "b.png", "link.png"))
    for path in (first, second):
        Image.new("RGB", (128, 128), (90, 80, 70)).save(path)
    link.symlink_to(second)
    for out in (first, second, link, tmp_path / "." / "a.png"):
        for overwrite in (True, False):
            with pytest.raises(PredictorError, match="is an input"):
                predict_files(first, second, predictor, out, overwrite)
    with pytest.raises(PredictorError, match="is an input"):
        predict_files(first, second, predictor, predictor)
    assert Image.open(first).size == (128, 128)
    out = tmp_path / "out.png"
    out.write_text("mine")
    with pytest.raises(PredictorError, match=r"exists; .* --force"):
        predict_files(first, second, predictor, out, overwrite=False)
    assert out.read_text() == "mine"
