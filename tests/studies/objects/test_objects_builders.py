"""What the configuration of the objects study names, and what it refuses."""

from __future__ import annotations

import pandas as pd
import pytest

from sensory_commutativity.errors import UserError
from sensory_commutativity.studies.loading import merge, validate
from sensory_commutativity.studies.objects import builders
from sensory_commutativity.studies.objects.builders import (
    check_masks,
    load_masks_robot,
    tuple_runs,
)
from sensory_commutativity.studies.objects.tables.mask_dof import mask_dof


def test_every_shift_of_the_data_is_tested_alone_and_all_together(default_config):
    masks = default_config.masks
    assert builders.test_set_names(default_config) == [
        "as-trained", "other-view", "other-objects", "other-apartments", "all-other"
    ]  # fmt: skip
    run = tuple_runs(default_config)["all-other"]
    assert run.family == "testing" and masks.data.scene not in run.scenes
    assert run.sets == {"all-other": masks.tests.field_of_view}
    fixed = load_masks_robot(default_config).description.fixed
    assert fixed["head_tilt_joint"] == masks.fixed["head_tilt_joint"]


def test_the_dof_with_the_scp_nearest_one_half_is_one_of_the_arm(default_config):
    apartment = default_config.apartment
    scp = {"right-wheel": 0.5, "left-wheel": 0.45, "torso-lift": 0.52, "shoulder-pan": 0.7,
           "shoulder-lift": 0.8, "elbow-flex": 0.9, "upperarm-roll": 1.0, "forearm-roll": 1.0,
           "wrist-flex": 1.0, "wrist-roll": 1.0}  # fmt: skip
    table = pd.DataFrame({"dof": [*scp], "scp": [*scp.values()]}).assign(
        robot=apartment.reference.robot,
        apartment=apartment.reference.scene,
        start="anywhere",
        length=apartment.sequence_length,
        field_of_view=apartment.fields_of_view[0],
    )
    table = pd.concat([table.assign(threshold=threshold) for threshold in apartment.thresholds])
    (row,) = mask_dof.compute(table, default_config).to_dict("records")
    assert row == {"robot": default_config.masks.robot, "dof": "shoulder-pan", "scp": 0.7}


def test_settings_that_make_no_sense_are_refused_before_any_work(default_config):
    refused = [
        ({"data": {"scene": "nowhere"}}, r"masks\.data\.scene names 'nowhere'"),
        ({"data": {"scene": "free-space"}}, "an empty floor, where nothing can be moved"),
        ({"tests": {"scenes": ["placida-stand-in"]}}, "which is trained in"),
        ({"tests": {"scenes": ["rs-stand-in", "rs-stand-in"]}}, "holds a name twice"),
        ({"tests": {"field_of_view": 45.0}}, "set another"),
        ({"tests": {"sequence_length": 7}}, "multiple of 2"),
        ({"image_size": 100}, "multiple of 32"),
        ({"robot": "jackrabbot"}, "set the same"),
        ({"fixed": {"nose_joint": 0.1}}, "masks: fixed: .* has no .*joint 'nose_joint'"),
        ({"fixed": {"shoulder_pan_joint": 0.1}}, "is moved by 'shoulder-pan'"),
        ({"map": {"cramped_room": "cellar"}}, "cramped_room: .* has no room 'cellar'"),
        ({"map": {"low_furniture": ["throne"]}}, "low_furniture: .* has no furniture 'throne'"),
    ]
    for change, message in refused:
        with pytest.raises(UserError, match=message):
            check_masks(validate(merge(default_config.model_dump(mode="json"), {"masks": change})))
