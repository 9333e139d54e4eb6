"""Tables that apply a predictor to pictures: made-up pictures say what is to be predicted."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from sensory_commutativity.change_detection import predictor as predictor_module
from sensory_commutativity.change_detection.decision import DecisionThresholds
from sensory_commutativity.change_detection.outcome import OUTCOMES
from sensory_commutativity.change_detection.simulated.object_experiments import COMPARISONS, KINDS
from sensory_commutativity.errors import TableError
from sensory_commutativity.storage.arrays import pack_masks, write_arrays
from sensory_commutativity.storage.checkpoints import save_state
from sensory_commutativity.studies import runner
from sensory_commutativity.studies.config import Config
from sensory_commutativity.studies.declarations import Table
from sensory_commutativity.studies.objects.arrays.local_scp_experiments import local_scp_experiments
from sensory_commutativity.studies.objects.arrays.mask_tuples import mask_tuples
from sensory_commutativity.studies.objects.builders import tuple_runs
from sensory_commutativity.studies.objects.tables.local_scp import local_scp
from sensory_commutativity.studies.objects.tables.mask_alternatives import mask_alternatives
from sensory_commutativity.studies.objects.tables.mask_scores import mask_scores
from sensory_commutativity.studies.registry import find_product
from tests.studies.examples import overlay
from tests.studies.objects.examples import DIFFERENT, MOVED

SIZE, PER_SCENE, N = 128, 5, 9
BLOCK = np.s_[..., 10:30, 20:40]
HALF_BLOCK = np.s_[..., 10:30, 20:30]


class Killed(BaseException):
    """Not an Exception: like a signal, nothing catches it."""


class Obedient:
    """Predicts the outcome that the first value of the first picture encodes; masks are BLOCK.

    It is killed in its call number `killed_at`.
    """

    thresholds = DecisionThresholds()

    def __init__(self, killed_at: int | None = None):
        self.calls, self.killed_at = 0, killed_at

    def predict_proba(self, pictures: np.ndarray) -> np.ndarray:
        self.calls += 1
        if self.calls == self.killed_at:
            raise Killed
        return make_masks(pictures[:, 0, 0, 0, 0], BLOCK).astype(np.float32)


def make_masks(outcomes: np.ndarray, block: tuple) -> np.ndarray:
    """Masks bool (*outcomes, 2, SIZE, SIZE): all that is different, a block of what moved."""
    masks = np.zeros((*outcomes.shape, 2, SIZE, SIZE), bool)
    masks[outcomes == DIFFERENT] = True
    moved = masks[outcomes == MOVED]
    moved[block] = True
    masks[outcomes == MOVED] = moved
    return masks


@pytest.fixture(scope="module")
def config(default_config) -> Config:
    tests = {"experiments": N, "tuples": 2, "experiments_per_scene": PER_SCENE}
    return overlay(default_config, masks={"tests": tests, "map": {"experiments": 3}})


@pytest.fixture(scope="module")
def played(config, tmp_path_factory) -> tuple[dict[str, list[Path]], dict[str, dict]]:
    """Files of tuples of each run, and their content, with what is to be predicted.

    Of what moved, half of what is predicted is true.
    """
    folder, rng = tmp_path_factory.mktemp("tuples"), np.random.default_rng(0)
    files, contents = {}, {}
    for run in tuple_runs(config).values():
        shape = (N, len(run.sets), len(COMPARISONS) if run.alternatives else 1)
        predicted, truth = rng.integers(3, size=shape), rng.integers(3, size=shape)
        pictures = np.zeros((*shape, 2, SIZE, SIZE, 3), np.uint8)
        pictures[..., 0, 0, 0, 0] = predicted
        second, first = rng.uniform(size=(2, N)) < 0.5
        arrays = dict(
            pictures=pictures,
            masks=pack_masks(make_masks(truth, HALF_BLOCK)),
            outcome=truth.astype(np.int8),
            kind=np.arange(N, dtype=np.int8) % 2,
            touched_fixed=second | first,
            touched_fixed_first=first,
            scene=np.arange(N, dtype=np.int32) // PER_SCENE,
            experiment=np.arange(N, dtype=np.int32),
        )
        contents[run.name] = {"predicted": predicted, **arrays}
        files[run.name] = []
        for shard in mask_tuples.shards.of_run(config, run.name):
            path = folder / mask_tuples.file(shard).name
            rows = slice(shard.start * PER_SCENE, shard.stop * PER_SCENE)
            metadata = runner.metadata_of(mask_tuples, config, shard)
            part = {name: array[rows] for name, array in arrays.items()}
            write_arrays(path, "mask_tuples", part, metadata)
            files[run.name].append(path)
        assert len(files[run.name]) == 2
    return files, contents


def write_predictor(path: Path, config: Config, content: str) -> None:
    """A file that says that it is the predictor of the run."""
    product = find_product("mask_predictor")
    (run,) = product.shards.of_run(config, "raft")
    save_state(path, {"about": runner.metadata_of(product, config, run), "content": content})


@pytest.fixture
def model(config, tmp_path) -> Path:
    write_predictor(tmp_path / "raft.predictor", config, "a predictor")
    return tmp_path / "raft.predictor"


@pytest.fixture
def write(config, model, tmp_path, monkeypatch):
    """Computes a table with a predictor that may be killed; how often it predicted."""

    def write(
        table: Table, files: list[Path], predictor: Obedient, shard: str | None = None
    ) -> int:
        monkeypatch.setattr(predictor_module, "load_predictor", lambda *_: predictor)
        part = table.shards.find(config, shard) if shard else None
        runner.write_product(table, config, [model, *files], tmp_path / table.file(part).name, part)
        assert not list(tmp_path.glob(".*")), "batches are left"
        return predictor.calls

    return write


def is_correct_move(table: pd.DataFrame) -> pd.Series:
    return (table["outcome_true"] == "moved") & (table["outcome_predicted"] == "moved")


def test_scores_are_of_the_first_tuples_through_the_right_camera(config, played, write, tmp_path):
    runs, contents = played
    files = [file for paths in runs.values() for file in paths]
    with pytest.raises(Killed):
        write(mask_scores, files, Obedient(8), "raft")
    assert not (tmp_path / "raft.parquet").exists()
    calls = write(mask_scores, files, Obedient(), "raft")
    # one call per file and camera: ten, of which the batches of the first two runs (4, 2) are kept
    assert calls == 4
    table = runner.read_shards(mask_scores, config, [tmp_path / "raft.parquet"])[0]
    assert (table["model"] == "raft").all()
    for run in tuple_runs(config).values():
        for camera, test_set in enumerate(run.sets):
            rows = table[table["test_set"] == test_set]
            predicted = contents[run.name]["predicted"][:, camera, 0]
            truth = contents[run.name]["outcome"][:, camera, 0]
            first = np.sort(np.concatenate([np.nonzero(truth == o)[0][:2] for o in range(3)]))
            assert rows["experiment"].tolist() == first.tolist()
            assert rows["household"].tolist() == (first // PER_SCENE).tolist()
            assert rows["kind"].tolist() == [KINDS[i % 2] for i in first]
            assert rows["outcome_true"].tolist() == [OUTCOMES[o] for o in truth[first]]
            assert rows["outcome_predicted"].tolist() == [OUTCOMES[o] for o in predicted[first]]
    correct = table[is_correct_move(table)]
    assert len(correct) and (correct[["iou_1", "iou_2"]] == 0.5).all(axis=None)
    assert (correct["intersection"] == 400).all() and (correct["union"] == 800).all()
    assert table.loc[table["outcome_true"] != "moved", "iou_1"].isna().all()


def test_alternatives_are_those_of_every_experiment(config, played, write, tmp_path):
    files, arrays = played[0]["as-trained"], played[1]["as-trained"]
    with pytest.raises(Killed):
        write(mask_alternatives, files, Obedient(4))
    assert write(mask_alternatives, files, Obedient()) == len(COMPARISONS)  # the second of 2 files
    table = runner.read_product(mask_alternatives, config, tmp_path / "mask_alternatives.parquet")
    assert len(table) == N * len(COMPARISONS)
    for k, comparison in enumerate(COMPARISONS):
        rows = table[table["comparison"] == comparison].sort_values("experiment")
        assert rows["experiment"].tolist() == list(range(N))
        assert rows["household"].tolist() == [i // PER_SCENE for i in range(N)]
        truth, predicted = arrays["outcome"][:, 0, k], arrays["predicted"][:, 0, k]
        assert rows["outcome_true"].tolist() == [OUTCOMES[o] for o in truth]
        assert rows["outcome_predicted"].tolist() == [OUTCOMES[o] for o in predicted]
        assert rows["touched"].tolist() == arrays["touched_fixed"].tolist()
        assert rows["touched_first"].tolist() == arrays["touched_fixed_first"].tolist()
    correct = table[is_correct_move(table)]
    assert len(correct) and (correct["overlap"] == 0.5).all()


def test_another_predictor_starts_over(config, played, write, model):
    files = played[0]["as-trained"]
    with pytest.raises(Killed):
        write(mask_alternatives, files, Obedient(4))
    write_predictor(model, config, "another predictor")
    assert write(mask_alternatives, files, Obedient()) == 2 * len(COMPARISONS)


def test_the_local_scp_is_that_of_each_pose(config, write, tmp_path, monkeypatch):
    predicted = np.random.default_rng(0).integers(3, size=(2, 4, 3))  # files, poses, experiments
    first, second = local_scp_experiments.shards.all(config)[:2]
    monkeypatch.setattr(type(local_scp_experiments.shards), "all", lambda *_: [first, second])
    files = []
    for i, (shard, of_file) in enumerate(zip((first, second), predicted, strict=True)):
        pictures = np.zeros((12, 2, SIZE, SIZE, 3), np.uint8)
        pictures[:, 0, 0, 0, 0] = of_file.ravel()
        arrays = dict(
            pictures=pictures,
            different=np.zeros((4, 3), bool),
            pose=np.arange(12.0).reshape(4, 3) + 12 * i,
            clearance=np.array([-0.1, 0.2, -0.1, 0.2]),
            over_low=np.array([True, True, False, False]),
        )
        texts = dict(dof="shoulder-pan", rooms=json.dumps(["a", "b", "c", "d"]),
                     nearest=json.dumps(["wall", "", "wall", ""]))  # fmt: skip
        files.append(tmp_path / local_scp_experiments.file(shard).name)
        metadata = runner.metadata_of(local_scp_experiments, config, shard)
        write_arrays(files[-1], "local_scp_experiments", arrays, texts | metadata)
    with pytest.raises(Killed):
        write(local_scp, files, Obedient(2))
    assert write(local_scp, files, Obedient()) == 1
    table = runner.read_product(local_scp, config, tmp_path / "local_scp.parquet")
    different = (predicted == DIFFERENT).sum(2).ravel()
    assert table["different"].tolist() == different.tolist()
    assert table["scp"].tolist() == pytest.approx(1 - different / 3)
    assert table["x"].tolist() == [3.0 * i for i in range(8)]
    assert table["room"].tolist() == list("abcd") * 2
    assert table["within_reach"].tolist() == [True, False] * 4
    assert table["over_low"].tolist() == [False, True, False, False] * 2
    assert (table["scp_true"] == 1).all()
    other = overlay(config, masks={"map": {"experiments": 6}})
    with pytest.raises(TableError, match="other settings than this configuration has"):
        runner.write_product(
            local_scp, other, [tmp_path / "raft.predictor", *files], tmp_path / "out.parquet"
        )
