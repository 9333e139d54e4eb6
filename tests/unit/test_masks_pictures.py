"""masks/: outcomes, households, pairs and SC-experiments on objects, in small scenes of our own making."""

from __future__ import annotations

import math

import numpy as np
import pytest
from sensory_commutativity.helpers import DEFAULT

from sensory_commutativity.change_detection.outcome import (
    OUTCOMES,
    SEEN,
    arm_change,
    image_shift,
    masks_of,
    outcome_of,
)
from sensory_commutativity.change_detection.simulated.object_experiments import (
    COMPARISONS,
    ObjectExperiments,
    tuples_of,
)
from sensory_commutativity.change_detection.simulated.pairs import PairFactory
from sensory_commutativity.change_detection.simulated.photometric import (
    apply_camera_noise,
    jitter_camera,
    sample_light,
)
from sensory_commutativity.change_detection.simulated.scene_sampler import displaced
from sensory_commutativity.errors import ConfigError, UserError
from sensory_commutativity.storage.arrays import unpack
from sensory_commutativity.studies.loading import load, merge, validate
from sensory_commutativity.studies.objects.builders import (
    check_masks,
    dof_nearest_half,
    household_of_pairs,
    household_of_tests,
    map_jobs,
    names_of_test_sets,
    robot_of_masks,
    tuple_jobs,
    tuple_runs,
)
from sensory_commutativity.worlds.apartment import frames as fr
from sensory_commutativity.worlds.apartment.rendering.camera import Camera, Picture
from sensory_commutativity.worlds.apartment.scenes.scene import IDENTITIES

IDENTICAL, DIFFERENT, MOVED = range(3)
WALL = IDENTITIES["fixture"]


@pytest.fixture(scope="module")
def config():
    small = {"masks": {"objects": 16}, "apartment": {"supersampling": 1}}
    return validate(merge(load(DEFAULT).model_dump(mode="json"), small))


def view(size: int = 128) -> Picture:
    """A wall two metres ahead."""
    return Picture(
        np.zeros((size, size, 3), np.uint8),
        np.full((size, size), WALL, np.int32),
        np.full((size, size), 2.0, np.float32),
    )


def turned(degrees: float) -> np.ndarray:
    return fr.turned(np.array([0.0, 0.0, 1.0]), math.radians(degrees))


# ---- outcomes ----------------------------------------------------------------------------------------------------------------


def test_the_shift_of_a_turning_camera_is_what_its_angle_says():
    camera = Camera(128, 128, 90.0)
    assert image_shift(view(), np.eye(4), np.eye(4), camera) == pytest.approx(0, abs=1e-12)
    for degrees in (0.5, 1.0, 2.0):
        shift = image_shift(view(), np.eye(4), turned(degrees), camera) * 128
        assert (
            64 * math.radians(degrees) < shift < 2 * 64 * math.radians(degrees)
        )  # at the edges more than in the middle
    assert math.isinf(image_shift(view(), np.eye(4), turned(180), camera))


@pytest.mark.parametrize(
    ("degrees", "outcome"),
    [(0.0, "identical"), (0.5, "identical"), (3.0, "different"), (90.0, "different")],
)
def test_a_robot_that_ended_elsewhere_is_told_by_the_picture(degrees, outcome):
    found, masks = outcome_of(
        view(), view(), np.eye(4), turned(degrees), np.array([], int), Camera(128, 128, 90.0)
    )
    assert (
        found == outcome
        and masks.all() == (outcome == "different")
        and masks.any() == (outcome == "different")
    )


def test_what_moved_is_masked_where_it_is_seen_in_each_view():
    first, second = view(), view()
    first.identity[10:20, 10:20], second.identity[40:44, 10:20] = (
        IDENTITIES["movable"] + 3,
        IDENTITIES["movable"] + 3,
    )
    found, masks = outcome_of(
        first, second, np.eye(4), np.eye(4), np.array([3]), Camera(128, 128, 90.0)
    )
    assert found == "moved" and masks.sum((1, 2)).tolist() == [100, 40]
    assert np.array_equal(masks, masks_of(first, second, np.array([3])))
    assert (
        outcome_of(first, second, np.eye(4), np.eye(4), np.array([2]), Camera())[0] == "identical"
    )
    assert (
        outcome_of(first, second, np.eye(4), turned(5), np.array([3]), Camera())[0] == "different"
    )
    few = view()
    few.identity[0, : SEEN - 1] = IDENTITIES["movable"]
    assert outcome_of(few, view(), np.eye(4), np.eye(4), np.array([0]), Camera())[0] == "identical"


def test_an_arm_that_ended_elsewhere_makes_another_view():
    first, second = view(), view()
    first.identity[:20, :20], second.identity[:20, 20:40] = IDENTITIES["robot"], IDENTITIES["robot"]
    assert arm_change(first, second) == pytest.approx(800 / 128**2)
    assert (
        outcome_of(first, second, np.eye(4), np.eye(4), np.array([], int), Camera())[0]
        == "different"
    )


# ---- sensor ------------------------------------------------------------------------------------------------------------------


def test_a_photograph_is_almost_the_picture():
    rng = np.random.default_rng(0)
    picture = rng.integers(30, 200, (64, 64, 3)).astype(np.uint8)
    seen = np.array([apply_camera_noise(picture, rng) for _ in range(20)])
    assert (seen != picture).any((1, 2, 3)).all() and np.abs(seen.astype(int) - picture).mean() < 15
    assert np.linalg.norm(sample_light(rng)) == pytest.approx(1)
    eye = jitter_camera(np.eye(4), 0.4, rng)
    assert (
        eye[:3, :3] @ eye[:3, :3].T == pytest.approx(np.eye(3))
        and 0 < np.abs(eye - np.eye(4)).max() < 0.05
    )


def test_what_is_displaced():
    before = np.array([[0, 0, 0, 0, 0, 0, 1.0]] * 4)
    after = before.copy()
    after[1, 0], after[2, 0] = 0.009, 0.011
    after[3, 3:] = [0, 0, math.sin(math.radians(3)), math.cos(math.radians(3))]
    assert displaced(before, after).tolist() == [2, 3]


# ---- pairs and experiments -----------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def factory(config):
    return PairFactory(household_of_pairs(config, "training", 0))


@pytest.mark.parametrize("outcome", OUTCOMES)
def test_pairs_are_what_they_should_be(factory, outcome):
    pairs = [factory.pair(outcome) for _ in range(12)]
    for pair in pairs:
        assert pair.outcome == outcome and pair.pictures.shape == (2, 128, 128, 3)
        share = pair.masks.mean()
        assert share == {"identical": 0, "different": 1}.get(outcome, share)
        if outcome == "moved":
            assert SEEN <= pair.masks.sum() < 0.9 * pair.masks.size
            change = np.abs(pair.pictures[0].astype(int) - pair.pictures[1]).max(-1)
            assert change[pair.masks.any(0)].mean() > change[~pair.masks.any(0)].mean()
    if outcome == "identical":
        assert all(
            (pair.pictures[0] != pair.pictures[1]).any() for pair in pairs
        )  # never byte-identical


def test_equal_jobs_make_equal_pairs(config):
    one, other, another = (
        PairFactory(household_of_pairs(config, "validation", job)).pair("moved")
        for job in (1, 1, 2)
    )
    assert np.array_equal(one.pictures, other.pictures) and np.array_equal(one.masks, other.masks)
    assert not np.array_equal(one.pictures, another.pictures)


def test_experiments_on_objects_are_labelled_and_play_their_alternatives(config):
    run = tuple_runs(config)["as-trained"]
    household = household_of_tests(config, run, 0)
    experiments = ObjectExperiments(household, 3, 20, run.alternatives)
    found = tuples_of([experiments.play() for _ in range(10)], household)
    assert found["pictures"].shape == (10, 2, len(COMPARISONS), 2, 128, 128, 3) and found[
        "outcome"
    ].shape == (10, 2, 3)
    masks = unpack(found["masks"], 128)
    for outcome, mask in zip(found["outcome"].ravel(), masks.reshape(-1, 2, 128, 128), strict=True):
        assert (
            mask.all()
            if outcome == DIFFERENT
            else not mask.any()
            if outcome == IDENTICAL
            else 0 < mask.sum() < mask.size
        )
    assert set(found["outcome"][:, :, 0].ravel()) >= {IDENTICAL, DIFFERENT}
    untouched = ~found["touched_fixed"] & (found["moved"][:, 0] == 0)
    assert (
        untouched.any() and (found["outcome"][untouched, :, 0] == IDENTICAL).all()
    )  # free space commutes
    assert (found["touched_fixed"] | ~found["touched_fixed_first"]).all()


def test_without_alternatives_only_both_orders_are_compared(config):
    run = tuple_runs(config)["all-other"]
    assert run.family == "testing" and not set(run.scenes) & {config.masks.data.scene}
    household = household_of_tests(config, run, 1)
    found = tuples_of([ObjectExperiments(household, 3, 6).play()], household)
    assert found["pictures"].shape == (1, 1, 1, 2, 128, 128, 3)
    assert household.cameras[0].field_of_view == config.masks.tests.field_of_view


# ---- configuration -----------------------------------------------------------------------------------------------------------


def test_all_shifts_are_tested_alone_and_together(config):
    assert names_of_test_sets(config) == [
        "as-trained",
        "other-view",
        "other-objects",
        "other-apartments",
        "all-other",
    ]
    assert tuple_jobs(config) == 2 and map_jobs(config) >= 1


def test_the_head_looks_where_the_configuration_says(config):
    assert (
        robot_of_masks(config).description.fixed["head_tilt_joint"]
        == config.masks.fixed["head_tilt_joint"]
    )


def test_the_dof_nearest_one_half_is_one_of_the_arm(config):
    import pandas as pd

    settings = config.apartment
    scp = {
        "right-wheel": 0.5,
        "left-wheel": 0.45,
        "torso-lift": 0.52,
        "shoulder-pan": 0.7,
        "shoulder-lift": 0.8,
        "elbow-flex": 0.9,
    }
    scp |= dict.fromkeys(["upperarm-roll", "forearm-roll", "wrist-flex", "wrist-roll"], 1.0)
    rows = [
        (
            settings.reference.robot,
            settings.reference.scene,
            "anywhere",
            settings.sequence_length,
            settings.fields_of_view[0],
            dof,
            threshold,
            value,
        )
        for threshold in settings.thresholds
        for dof, value in scp.items()
    ]
    table = pd.DataFrame(
        rows,
        columns=[
            "robot",
            "apartment",
            "start",
            "length",
            "field_of_view",
            "dof",
            "threshold",
            "scp",
        ],
    )
    assert dof_nearest_half(table, config) == ("shoulder-pan", 0.7)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"data": {"scene": "nowhere"}}, r"masks\.data\.scene names 'nowhere'"),
        ({"data": {"scene": "free-space"}}, "an empty floor, where nothing can be moved"),
        ({"tests": {"scenes": ["placida-stand-in"]}}, "which is trained in"),
        ({"tests": {"scenes": ["rs-stand-in", "rs-stand-in"]}}, "holds a name twice"),
        ({"tests": {"field_of_view": 45.0}}, "set another"),
        ({"tests": {"sequence_length": 7}}, "multiple of 2"),
        ({"image_size": 100}, "multiple of 32"),
        ({"robot": "jackrabbot"}, "set the same"),
        ({"fixed": {"nose_joint": 0.1}}, "masks: fixed: .* has no joint 'nose_joint'"),
        ({"fixed": {"shoulder_pan_joint": 0.1}}, "is moved by 'shoulder-pan'"),
        (
            {"map": {"cramped_room": "cellar"}},
            r"masks\.map\.cramped_room: 'rs-stand-in' has no room 'cellar'",
        ),
        ({"map": {"low_furniture": ["throne"]}}, r"masks\.map\.low_furniture: 'rs-stand-in' has no furniture 'throne'"),
    ],
)
def test_settings_that_make_no_sense_are_told_before_any_work(config, change, message):
    with pytest.raises((ConfigError, UserError), match=message):
        check_masks(validate(merge(config.model_dump(mode="json"), {"masks": change})))
