"""masks/: losses, decisions, files, models, training and predictors, without any simulation."""

from __future__ import annotations

import re
import zlib

import numpy as np
import pytest
import torch
from PIL import Image

from sensory_commutativity.change_detection.decision import (
    DecisionThresholds,
    intersection_over_union,
    outcomes,
    remove_small_components,
    tune,
)
from sensory_commutativity.change_detection.models.flownet import MaskFlowNet
from sensory_commutativity.change_detection.models.image_difference import difference
from sensory_commutativity.change_detection.models.raft import MaskRaft
from sensory_commutativity.change_detection.models.view_classifier import ViewClassifier
from sensory_commutativity.change_detection.outcome import OUTCOMES
from sensory_commutativity.change_detection.pair_files import Pairs, read_pairs, write_pairs
from sensory_commutativity.change_detection.predict import as_trained, predict_files
from sensory_commutativity.change_detection.predictor import (
    MODELS,
    PREDICTORS,
    MaskPredictor,
    Prediction,
    PredictorError,
    as_tensor,
    checked,
    load_predictor,
)
from sensory_commutativity.change_detection.simulated.pairs import Pair
from sensory_commutativity.change_detection.training.loss import dice_loss, mask_loss
from sensory_commutativity.change_detection.training.mask_trainer import (
    AIMED,
    STAGES,
    MaskTrainer,
    augmented,
    stage_of,
)
from sensory_commutativity.change_detection.training.trainer import TrainingSettings, learning_rate
from sensory_commutativity.storage.arrays import StoreError, pack, read_arrays, unpack, write_arrays
from sensory_commutativity.storage.checkpoints import CheckpointError, save_state

IDENTICAL, DIFFERENT, MOVED = range(3)
SMALL = {
    "raft": dict(widths=(8, 12, 16, 16, 24), hidden=16, context=16, updates=2, fine=12, sharp=8),
    "flownet": dict(scale=0.05),
}


def some_pairs(n: int = 6, size: int = 128) -> Pairs:
    """Noise; a bright square somewhere else in the second picture of every third pair."""
    rng = np.random.default_rng(0)
    pictures = rng.integers(60, 120, (n, 2, size, size, 3)).astype(np.uint8)
    masks, outcome = np.zeros((n, 2, size, size), bool), np.arange(n) % 3
    for i in range(n):
        if outcome[i] == DIFFERENT:
            masks[i] = True
        else:
            pictures[i, 1] = pictures[i, 0]
        if outcome[i] == MOVED:
            for view, at in enumerate((20, 70)):
                masks[i, view, 30:50, at : at + 20] = True
            pictures[i][masks[i]] = 250
    return Pairs(pictures, masks, outcome.astype(np.int8), tuple(OUTCOMES[k] for k in outcome))


# ---- decisions ---------------------------------------------------------------------------------------------------------------


def test_outcomes_by_hand():
    maps = np.zeros((4, 2, 128, 128))
    maps[1] = 0.9
    maps[2, 0, :4, :4] = 0.8
    maps[3, 0, :4, :3] = 0.8  # twelve pixels are too few
    assert outcomes(maps, DecisionThresholds(0.5, 0.7, 16)).tolist() == [
        IDENTICAL,
        DIFFERENT,
        MOVED,
        IDENTICAL,
    ]
    assert outcomes(maps, DecisionThresholds(0.5, 0.7, 12)).tolist()[3] == MOVED
    assert outcomes(maps[:, :, ::2, ::2], DecisionThresholds(0.5, 0.7, 16)).tolist()[:3] == [
        IDENTICAL,
        DIFFERENT,
        MOVED,
    ]  # areas are those of 128 x 128


def test_overlap_by_hand():
    truth, maps = np.zeros((1, 2, 8, 8), bool), np.zeros((1, 2, 8, 8))
    truth[0, 0, :4, :4], maps[0, 0, :4, :2] = True, 0.6
    assert intersection_over_union(maps, truth)[0].tolist() == pytest.approx(
        [0.5, np.nan], nan_ok=True
    )
    maps[0, 1, 0, 0] = 1.0  # what is predicted where nothing is counts against it
    assert intersection_over_union(maps, truth)[0].tolist() == [0.5, 0.0]


def test_specks_are_taken_away():
    maps = np.zeros((1, 2, 128, 128), np.float32)
    maps[0, 0, :3, :3], maps[0, 0, 50:54, 50:54], maps[0, 1, 0, 0] = 0.9, 0.9, 0.4
    found = remove_small_components(maps)
    assert (found > 0.5).sum() == 16 and found[0, 1, 0, 0] == np.float32(0.4) and maps.max() > 0


class Sided(torch.nn.Module):
    """Sees what is bright in the first picture, a pixel too far to the left, and nothing in the second."""

    def forward(self, first, second):
        return [
            torch.stack([20 * first.mean(1).roll(-1, -1), torch.full_like(first[:, 0], -20.0)], 1)
        ]


def test_what_moved_does_not_depend_on_the_way_of_looking():
    pictures = np.zeros((1, 2, 64, 64, 3), np.uint8)
    pictures[0, 1, 10:30, 20:40] = 255
    found = MaskPredictor("raft", Sided()).probabilities(pictures)
    assert np.allclose(
        found, 0, atol=1e-4
    )  # the first way of looking sees nothing, so nobody looks again
    found = MaskPredictor("raft", Sided()).probabilities(pictures[:, ::-1])
    assert np.allclose(
        found[..., ::-1],
        MaskPredictor("raft", Sided()).probabilities(pictures[:, ::-1, :, ::-1]),
        atol=1e-6,
    )


def test_the_rule_is_tuned_to_the_highest_accuracy():
    maps = np.zeros((3, 2, 128, 128))
    maps[1], maps[2, 0, :10, :10] = 0.45, 0.65
    truth = np.array([IDENTICAL, DIFFERENT, MOVED])
    rule = tune(maps, truth)
    assert (outcomes(maps, rule) == truth).all() and not (
        outcomes(maps, DecisionThresholds()) == truth
    ).all()


# ---- losses ------------------------------------------------------------------------------------------------------------------


def test_the_dice_loss_by_hand():
    masks = torch.zeros(1, 2, 8, 8)
    masks[0, 0, :2] = 1.0
    assert dice_loss(200 * masks - 100, masks).item() == pytest.approx(0.0, abs=1e-6)
    assert dice_loss(torch.full_like(masks, -100.0), masks).item() == pytest.approx(
        (1 - 10 / 26) / 2
    )  # the empty mask is right
    assert dice_loss(torch.full_like(masks, 100.0), masks).item() == pytest.approx(
        (1 - 42 / 90 + 1 - 10 / 74) / 2
    )


def test_later_refinements_count_for_more_and_dice_only_where_something_moved():
    masks, good, bad = (
        torch.zeros(1, 2, 8, 8),
        torch.full((1, 2, 8, 8), -5.0),
        torch.full((1, 2, 8, 8), 5.0),
    )
    no, yes = torch.tensor([False]), torch.tensor([True])
    assert mask_loss([bad, good], masks, no) < mask_loss([good, bad], masks, no)
    assert mask_loss([bad], masks, yes) > mask_loss([bad], masks, no)


# ---- files -------------------------------------------------------------------------------------------------------------------


def test_masks_are_packed_and_unpacked():
    masks = np.random.default_rng(0).uniform(size=(3, 2, 5, 13)) < 0.5
    assert np.array_equal(unpack(pack(masks), 13), masks)


def test_pairs_are_read_as_they_were_written(tmp_path):
    pairs = some_pairs()
    listed = [
        Pair(pairs.pictures[i], pairs.masks[i], OUTCOMES[pairs.outcome[i]], pairs.kind[i])
        for i in range(6)
    ]
    write_pairs(tmp_path / "a.h5", listed[:4], {"seed": "1"})
    write_pairs(tmp_path / "b.h5", listed[4:], {"seed": "1"})
    again = read_pairs(tmp_path / "a.h5", tmp_path / "b.h5")
    assert all(np.array_equal(x, y) for x, y in zip(pairs, again, strict=True))
    write_pairs(tmp_path / "c.h5", listed[:4], {"seed": "1"})
    assert (tmp_path / "a.h5").read_bytes() == (tmp_path / "c.h5").read_bytes()


def test_files_of_pairs_of_several_sizes_are_refused(tmp_path):
    for size in (64, 128):
        pairs = some_pairs(3, size)
        write_pairs(
            tmp_path / f"{size}.h5",
            [Pair(pairs.pictures[i], pairs.masks[i], "moved", "x") for i in range(3)],
            {},
        )
    with pytest.raises(StoreError, match="pictures of several sizes"):
        read_pairs(tmp_path / "64.h5", tmp_path / "128.h5")


@pytest.mark.parametrize("spoil", ["missing", "truncated", "flipped", "said", "text", "other"])
def test_a_file_that_cannot_be_used_is_told(tmp_path, spoil):
    path = tmp_path / "a.h5"
    if spoil != "missing":
        write_arrays(
            path,
            "other" if spoil == "other" else "pairs",
            {"pictures": np.arange(6000, dtype=np.uint8).reshape(10, 20, 30)},
            {"rooms": "kitchen"},
        )
        data = bytearray(path.read_bytes())
        place = data.find(bytes(range(40, 60)))
        if spoil == "truncated":
            path.write_bytes(data[: len(data) // 2])
        elif spoil == "flipped":
            data[place if place > 0 else -400] ^= 64
            path.write_bytes(data)
        elif spoil == "said":
            path.write_bytes(bytes(data).replace(b"kitchen", b"xitchen"))
        elif spoil == "text":
            path.write_text("no HDF5")
    message = {"missing": "there is no such file", "other": "no file of pairs"}.get(
        spoil, "damaged"
    )
    with pytest.raises(StoreError, match=message):
        read_arrays(path, "pairs")


# ---- models ------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", MODELS)
def test_models_refine_two_masks_of_the_size_of_the_pictures(name):
    model = MODELS[name](**SMALL[name])
    first, second = torch.rand(2, 2, 3, 64, 96).unbind(1)[0], torch.rand(2, 3, 64, 96)
    found = model(first, second)
    assert len(found) > 1 and all(
        logits.shape == (2, 2, 64, 96) and torch.isfinite(logits).all() for logits in found
    )
    sum(logits.mean() for logits in found).backward()
    assert all(parameter.grad is not None for parameter in model.parameters())


def test_both_models_are_of_a_size():
    raft, flownet = (
        sum(parameter.numel() for parameter in model.parameters())
        for model in (MaskRaft(), MaskFlowNet())
    )
    assert (
        0.8 < raft / flownet < 1.25 and raft * 2 < 5e6
    )  # bytes in half precision: small enough to ship


def test_the_image_difference_forgives_a_pixel_and_exposure_and_sees_the_rest():
    rng = np.random.default_rng(1)
    picture = np.repeat(np.repeat(rng.integers(40, 180, (16, 16, 3)), 8, 0), 8, 1).astype(np.uint8)
    shifted = np.clip(np.roll(picture, 1, 1) * 1.05, 0, 255).astype(np.uint8)
    changed = picture.copy()
    changed[20:60, 30:70] = 255 - changed[20:60, 30:70]
    other = rng.integers(0, 255, picture.shape).astype(np.uint8)
    found = difference(
        np.stack([np.stack([picture, second]) for second in (shifted, changed, other)])
    )
    assert (found[0][:, 4:-4, 4:-4] > 0.5).mean() < 0.02
    assert (found[1][:, 25:55, 35:65] > 0.5).mean() > 0.7 and (
        found[1][:, 80:, 80:] > 0.5
    ).mean() == 0
    assert outcomes(found, DecisionThresholds()).tolist()[2] == DIFFERENT


# ---- training ----------------------------------------------------------------------------------------------------------------


def test_the_learning_rate_rises_and_falls():
    recipe = TrainingSettings(samples=4800, learning_rate=0.01)
    rates = np.array([learning_rate(recipe, step) for step in range(recipe.steps)])
    top = int(np.argmax(rates))
    assert max(rates) == pytest.approx(0.01) and 0 < top < 20 and rates[-1] < 1e-5
    assert all(np.diff(rates[: top + 1]) > 0) and all(np.diff(rates[top + 1 :]) < 0)


def test_a_trained_model_fits_what_it_is_shown():
    pairs = some_pairs()
    trainer = MaskTrainer(
        "raft",
        TrainingSettings(samples=1440, batch_size=6, learning_rate=3e-3),
        pairs,
        seed=1,
        **SMALL["raft"],
    )

    def loss() -> float:
        x, y = as_tensor(pairs.pictures, "cpu"), torch.from_numpy(pairs.masks).float()
        with torch.no_grad():
            return float(
                mask_loss(
                    trainer.model(x[:, 0], x[:, 1]), y, torch.from_numpy(pairs.outcome == MOVED)
                )
            )

    before = loss()
    while not trainer.finished:
        trainer.advance()
    assert loss() < 0.75 * before


@pytest.mark.parametrize("name", MODELS)
def test_a_resumed_run_ends_as_one_that_was_not(name):
    pairs = some_pairs()

    def run(stop_at: int | None) -> list[torch.Tensor]:
        trainer = MaskTrainer(
            name, TrainingSettings(samples=24, batch_size=4), pairs, seed=3, **SMALL[name]
        )
        while not trainer.finished:
            trainer.advance()
            if trainer.step == stop_at:
                state = trainer.state()
                trainer = MaskTrainer(
                    name, TrainingSettings(samples=24, batch_size=4), pairs, seed=3, **SMALL[name]
                )
                trainer.resume(state)
        assert len(trainer.losses) == trainer.recipe.steps
        return list(trainer.model.state_dict().values())

    for stop_at in (1, 4):
        assert all(torch.equal(a, b) for a, b in zip(run(None), run(stop_at), strict=True))


def test_only_pairs_in_which_something_moved_are_cut_out():
    trainer = MaskTrainer(
        "flownet",
        TrainingSettings(samples=4000, batch_size=64),
        some_pairs(12),
        seed=3,
        **SMALL["flownet"],
    )
    kinds = set()
    for trainer.step in range(8):
        _, masks, moved = trainer._batch()
        whole = bool((masks > 0.5).flatten(1).all(1).any())  # pairs of another view are among them
        kinds.add(whole)
        assert 0.4 < moved.float().mean() < 0.8 if whole else moved.float().mean() > 0.8
    assert kinds == {True, False}


def test_augmentation_changes_both_pictures_alike_and_takes_the_masks_along():
    pairs = some_pairs(30)
    pictures, masks = augmented(pairs.pictures, pairs.masks, np.random.default_rng(0))
    identical = pairs.outcome == IDENTICAL
    assert np.array_equal(pictures[identical, 0], pictures[identical, 1])
    assert (pictures != pairs.pictures).any((1, 2, 3, 4)).all()
    moved = pairs.outcome == MOVED
    assert (masks[moved].sum((1, 2, 3)) == 800).all()
    bright = pictures[moved].astype(int).sum(-1)
    assert all(
        bright[i][masks[moved][i]].mean() > bright[i][~masks[moved][i]].mean() + 100
        for i in range(moved.sum())
    )


def test_a_stage_shows_what_it_says():
    trainer = MaskTrainer(
        "flownet",
        TrainingSettings(samples=24_000, batch_size=4),
        some_pairs(),
        seed=3,
        **SMALL["flownet"],
    )
    starts = [0, *(round(stage.until * trainer.recipe.steps) for stage in STAGES)]
    assert starts[-1] == trainer.recipe.steps
    for stage, start, end in zip(STAGES, starts, starts[1:], strict=False):
        steps = trainer.recipe.steps
        assert stage_of(start, steps) == stage_of(end - 1, steps) == stage
        whole, moved = [], []
        for trainer.step in range(start, start + 60):
            pictures, _, is_moved = trainer._batch()
            whole.append(pictures.shape[-1] == 128)
            moved.append(float(is_moved.float().mean()) if whole[-1] else np.nan)
        assert np.mean(whole) == pytest.approx(stage.whole, abs=0.2) and any(whole) == (
            stage.whole > 0
        )
        if stage.whole:
            assert np.nanmean(moved) == pytest.approx(stage.moved, abs=0.12)


def test_parts_are_cut_out_where_something_moved():
    pairs = some_pairs()
    masks = np.zeros_like(pairs.masks)
    masks[:, :, 100:110, 20:30] = True
    pictures = np.where(masks[..., None], np.uint8(255), np.uint8(0)).repeat(3, -1)
    trainer = MaskTrainer(
        "flownet", TrainingSettings(samples=400, batch_size=4), pairs, seed=3, **SMALL["flownet"]
    )
    x, y = trainer._cut_out(pictures, masks, np.random.default_rng(1))
    assert x.shape == (len(masks), 2, 3, 64, 64) and y.shape == (len(masks), 2, 64, 64)
    shown = (y > 0.5).flatten(1).any(1).float().mean()
    assert shown > AIMED - 0.1
    assert torch.allclose((x[:, :, 0] + 1) / 2, y, atol=1e-5)  # both are cut out and enlarged alike


# ---- predictors --------------------------------------------------------------------------------------------------------------


@pytest.fixture
def predictor(tmp_path):
    path = tmp_path / "raft.predictor"
    torch.manual_seed(0)
    MaskPredictor(
        "raft",
        MaskRaft(**SMALL["raft"]),
        DecisionThresholds(0.4, 0.6, 8.0),
        judge=ViewClassifier(4),
    ).save(path, {"seed": "1"})
    return path


def test_a_predictor_is_read_as_it_was_written(predictor):
    loaded = load_predictor(predictor, "raft")
    assert loaded.rule == DecisionThresholds(0.4, 0.6, 8.0)
    torch.manual_seed(0)
    for written, read in (
        (MaskRaft(**SMALL["raft"]), loaded.model),
        (ViewClassifier(4), loaded.view_classifier),
    ):
        pairs = zip(written.state_dict().items(), read.state_dict().items(), strict=True)
        assert all(
            name == other and torch.allclose(a.float(), b.float(), atol=1e-3)
            for (name, a), (other, b) in pairs
        )
    pictures = some_pairs(3).pictures
    assert np.array_equal(
        loaded.probabilities(pictures, batch_size=1),
        load_predictor(predictor).probabilities(pictures, batch_size=1),
    )
    found = loaded.probabilities(pictures)
    assert (
        found.shape == (3, 2, 128, 128)
        and found.dtype == np.float32
        and 0 <= found.min() <= found.max() <= 1
    )


def test_the_difference_is_a_predictor_too(tmp_path):
    MaskPredictor("difference", None, DecisionThresholds(0.3, 0.5, 12.0)).save(
        tmp_path / "d.predictor", {}
    )
    loaded = load_predictor(tmp_path / "d.predictor", "difference")
    assert loaded.rule.different == 0.3 and set(PREDICTORS) == {"raft", "flownet", "difference"}
    assert loaded.predict(*some_pairs(3).pictures[0]).outcome == "identical"


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (dict(format=0), "another version"),
        (dict(name="unet"), "no mask predictor"),
        (
            dict(model=dict(architecture=dict(SMALL["raft"], hidden=32), weights={})),
            "another architecture",
        ),
        (dict(model=dict(architecture=dict(unknown=1), weights={})), "another architecture"),
        (dict(judge=dict(architecture=dict(width=8), weights={})), "another architecture"),
        (dict(model=None), "another architecture"),
    ],
)
def test_a_file_of_something_else_is_told(predictor, tmp_path, change, message):
    from sensory_commutativity.storage.checkpoints import load_state

    save_state(tmp_path / "x.predictor", load_state(predictor, "") | change)
    with pytest.raises(PredictorError, match=message):
        load_predictor(tmp_path / "x.predictor")


def test_another_model_and_damage_are_told(predictor, tmp_path):
    with pytest.raises(PredictorError, match="holds the model 'raft', not 'flownet'"):
        load_predictor(predictor, "flownet")
    (tmp_path / "half.predictor").write_bytes(predictor.read_bytes()[:2000])
    with pytest.raises(CheckpointError, match="damaged"):
        load_predictor(tmp_path / "half.predictor")


@pytest.mark.parametrize(
    ("pictures", "message"),
    [
        (np.zeros((1, 2, 128, 128, 3)), "must be uint8"),
        (np.zeros((2, 128, 128, 3), np.uint8), "must be uint8 of the shape"),
        (
            np.zeros((1, 2, 100, 128, 3), np.uint8),
            "100 x 128 pixels; sides must be multiples of 32",
        ),
        (np.zeros((1, 2, 32, 32, 3), np.uint8), "from 64 on"),
    ],
)
def test_pictures_that_a_predictor_cannot_take_are_told(pictures, message):
    with pytest.raises(PredictorError, match=message):
        checked(pictures)


def enormous(png: bytes) -> bytes:
    """A PNG file whose header says that it has 40,000 x 40,000 pixels."""
    start = png.index(b"IHDR")
    header = b"IHDR" + (40_000).to_bytes(4, "big") * 2 + png[start + 12 : start + 17]
    return png[:start] + header + zlib.crc32(header).to_bytes(4, "big") + png[start + 21 :]


def test_ones_own_pictures(predictor, tmp_path):
    first, second = some_pairs(3).pictures[2]
    for name, picture in (("a", first), ("b", second)):
        Image.fromarray(picture).save(tmp_path / f"{name}.png")
    said = predict_files(tmp_path / "a.png", tmp_path / "b.png", predictor, tmp_path / "out.png")
    assert said.split(":")[0] in OUTCOMES and str(tmp_path / "out.png") in said
    assert np.asarray(Image.open(tmp_path / "out.png")).shape == (128, 256, 3)
    (tmp_path / "text.png").write_text("no picture")
    whole = (tmp_path / "a.png").read_bytes()
    (tmp_path / "spoilt.png").write_bytes(whole[:60] + bytes(len(whole) - 60))
    (tmp_path / "huge.png").write_bytes(enormous(whole))
    for wrong, message in (
        ("text", "be read as a picture"),
        ("spoilt", "be read as a picture"),
        ("huge", "exceeds limit"),
        ("none", "no such file"),
    ):
        with pytest.raises(PredictorError, match=message):
            predict_files(
                tmp_path / "a.png", tmp_path / f"{wrong}.png", predictor, tmp_path / "out.png"
            )
    Image.fromarray(second[:40]).save(tmp_path / "tiny.png")
    with pytest.raises(
        PredictorError, match="40 x 128 pixels; give such of which both sides have at least 64"
    ):
        predict_files(tmp_path / "tiny.png", tmp_path / "tiny.png", predictor, tmp_path / "out.png")
    Image.fromarray(second[:64]).save(tmp_path / "small.png")
    with pytest.raises(PredictorError, match="different sizes, 128 x 128 and 64 x 128"):
        predict_files(tmp_path / "a.png", tmp_path / "small.png", predictor, tmp_path / "out.png")


@pytest.mark.parametrize(
    ("sides", "seen"),
    [
        ((128, 128), (128, 128)),
        ((480, 640), (128, 160)),
        ((3000, 2000), (192, 128)),
        ((64, 300), (128, 608)),
    ],
)
def test_ones_own_pictures_are_seen_as_large_as_those_of_the_training(sides, seen):
    picture = np.tile(np.linspace(0, 255, sides[1]).astype(np.uint8)[:, None], (sides[0], 1, 3))
    found = as_trained(picture)
    assert found.shape == (*seen, 3) and found.dtype == np.uint8
    assert np.abs(found[0, :, 0] - np.linspace(0, 255, seen[1])).max() < 4


def test_what_moved_in_ones_own_large_pictures_is_outlined_where_it_is(
    predictor, tmp_path, monkeypatch
):
    def predict(self, *pictures):
        assert all(picture.shape == (128, 160, 3) for picture in pictures)
        probabilities = np.zeros((2, 128, 160), np.float32)
        probabilities[0, 32:64, 40:80] = 1
        return Prediction("moved", probabilities)

    monkeypatch.setattr(MaskPredictor, "predict", predict)
    Image.new("RGB", (1280, 1024)).save(tmp_path / "a.png")
    said = predict_files(tmp_path / "a.png", tmp_path / "a.png", predictor, tmp_path / "out.png")
    assert "moved" in said and "0 in a.png" in said
    shown = np.asarray(Image.open(tmp_path / "out.png"))
    assert shown.shape == (1024, 2560, 3)
    rows, columns = np.nonzero(shown.any(2))
    assert (rows.min(), rows.max() + 1, columns.min(), columns.max() + 1) == (
        256 - 8,
        512 + 8,
        320 - 8,
        640 + 8,
    )


def test_the_predictor_that_comes_with_the_project_sees_what_moved(tmp_path):
    rng = np.random.default_rng(4)
    wall = np.linspace(90, 160, 400)[:, None, None] * np.array([1.0, 0.9, 0.8])
    empty = np.tile(wall, (1, 400, 1))
    empty[260:] = (120, 90, 60)  # a table
    first, second = empty.copy(), empty.copy()
    first[200:300, 60:150] = second[200:300, 240:330] = (200, 40, 40)
    for name, picture in (("first", first), ("second", second), ("again", first)):
        Image.fromarray(
            np.clip(picture + rng.normal(0, 2, picture.shape), 0, 255).astype(np.uint8)
        ).save(tmp_path / f"{name}.png")
    said = [
        predict_files(tmp_path / "first.png", tmp_path / other, None, tmp_path / "out.png")
        for other in ("again.png", "second.png")
    ]
    assert said[0].startswith("identical") and said[1].startswith("moved")
    pixels = [int(number) for number in re.findall(r"(\d+) (?:pixels )?in", said[1])]
    assert len(pixels) == 2 and all(7_000 < found < 11_500 for found in pixels), said[
        1
    ]  # 9,000 are right
