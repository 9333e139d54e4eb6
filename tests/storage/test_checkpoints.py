"""Checkpoints of runs, and files of models: exact, and damage is reported."""

from __future__ import annotations

import pytest
import torch

from sensory_commutativity.storage.checkpoints import (
    Checkpoint,
    CheckpointError,
    load_state,
    save_state,
)

STATE = {
    "policy": {"w": torch.tensor([0.1, -0.0, float("inf")])},
    "curve": [{"step": 5, "episode_return": 0.1 + 0.2}],
}
DAMAGE = {
    "cut in half": lambda data: data[: len(data) // 2],
    "last byte missing": lambda data: data[:-1],
    "empty": lambda data: b"",
    "garbage": lambda data: b"not a checkpoint",
    "beginning missing": lambda data: data[40:],
    "one bit changed": lambda data: data[:700] + bytes([data[700] ^ 1]) + data[701:],
}


def test_a_checkpoint_returns_what_was_saved_last(tmp_path):
    checkpoint = Checkpoint(tmp_path / "run.parquet", "settings")
    assert checkpoint.load() is None
    checkpoint.save({"policy": {"w": torch.zeros(3)}, "curve": []})
    checkpoint.save(STATE)
    state = checkpoint.load()
    assert state["curve"] == STATE["curve"]
    assert torch.equal(state["policy"]["w"], STATE["policy"]["w"])
    assert [path.name for path in tmp_path.iterdir()] == [checkpoint.path.name]


def test_the_content_of_a_file_does_not_depend_on_its_name(tmp_path):
    for name in ("a.policy", "another-name.policy"):
        save_state(tmp_path / name, STATE)
    data = [path.read_bytes() for path in tmp_path.iterdir()]
    assert len(data) == 2 and data[0] == data[1]


def test_damaged_and_missing_files_are_reported_in_one_line_and_left_alone(tmp_path):
    checkpoint = Checkpoint(tmp_path / "run.parquet", "settings")
    for name, damage in DAMAGE.items():
        checkpoint.save(STATE)
        damaged = damage(checkpoint.path.read_bytes())
        checkpoint.path.write_bytes(damaged)
        with pytest.raises(CheckpointError, match="delete it") as error:
            checkpoint.load()
        assert str(checkpoint.path) in str(error.value) and "\n" not in str(error.value), name
        assert checkpoint.path.read_bytes() == damaged, name
    with pytest.raises(CheckpointError, match=r"none\.policy: .*; run again"):
        load_state(tmp_path / "none.policy", "run again")


def test_forget_removes_all_checkpoints_of_its_own_run_only(tmp_path):
    names = ["full.1.parquet", "full.11.parquet", "adapted.1.parquet"]
    for name in names:
        Checkpoint(tmp_path / name, "settings").save({})
    Checkpoint(tmp_path / names[0], "other settings").save({})
    assert Checkpoint(tmp_path / names[0], "third settings").load() is None
    for _ in range(2):  # forgetting nothing is no error
        Checkpoint(tmp_path / names[0], "settings").remove()
    assert [Checkpoint(tmp_path / name, "settings").load() for name in names] == [None, {}, {}]
    assert len(list(tmp_path.iterdir())) == 2
