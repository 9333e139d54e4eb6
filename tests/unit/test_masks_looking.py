"""Stages in which a predictor looks at what was played: made-up pictures whose first pixel says what is to be predicted, and kills on the way."""

from __future__ import annotations

import json

import numpy as np
import pytest

from sensory_commutativity.change_detection.decision import DecisionThresholds
from sensory_commutativity.change_detection.outcome import OUTCOMES
from sensory_commutativity.change_detection.simulated.object_experiments import COMPARISONS, KINDS
from sensory_commutativity.storage.arrays import ArrayFileError, pack_masks, write_arrays
from sensory_commutativity.storage.tables import read_table
from sensory_commutativity.studies.loading import load, merge, validate
from sensory_commutativity.studies.objects.builders import tuple_jobs, tuple_runs
from sensory_commutativity.studies.objects.tables import local_scp, mask_alternatives, mask_scores
from tests.helpers import DEFAULT

IDENTICAL, DIFFERENT, MOVED = range(3)
SIZE, PER_JOB, N = 64, 5, 9
BLOCK = np.s_[..., 10:30, 20:40]


class Killed(BaseException):
    """Not an Exception: nothing catches it, like a signal."""


class Obedient:
    """Predicts what the first pixel of the first picture says: an outcome, masks as in BLOCK. Dies when it is asked for the `dies_at`-th time."""

    rule = DecisionThresholds()

    def __init__(self, dies_at: int | None = None):
        self.asked, self.dies_at = 0, dies_at

    def predict_proba(self, pictures: np.ndarray) -> np.ndarray:
        self.asked += 1
        if self.asked == self.dies_at:
            raise Killed
        found = np.zeros((len(pictures), 2, SIZE, SIZE), np.float32)
        says = pictures[:, 0, 0, 0, 0]
        found[says == DIFFERENT] = 1
        moved = found[says == MOVED]
        moved[BLOCK] = 1
        found[says == MOVED] = moved
        return found


@pytest.fixture(scope="module")
def config():
    tests = {"experiments": N, "tuples": 2, "experiments_per_job": PER_JOB}
    return validate(
        merge(
            load(DEFAULT).model_dump(mode="json"),
            {"masks": {"tests": tests, "map": {"experiments": 3}}},
        )
    )


@pytest.fixture(scope="module")
def played(config, tmp_path_factory):
    """Files of tuples, by run, and everything that is in them: said and true outcomes, int (N, cameras, comparisons), by run, too."""
    folder, rng, files, known = tmp_path_factory.mktemp("tuples"), np.random.default_rng(0), {}, {}
    for run in tuple_runs(config).values():
        shape = (N, len(run.sets), len(COMPARISONS) if run.alternatives else 1)
        said, truth = rng.integers(3, size=shape), rng.integers(3, size=shape)
        pictures = np.zeros((*shape, 2, SIZE, SIZE, 3), np.uint8)
        pictures[..., 0, 0, 0, 0] = said
        masks = np.zeros((*shape, 2, SIZE, SIZE), bool)
        masks[truth == DIFFERENT] = True
        moved = masks[truth == MOVED]
        moved[..., 10:30, 20:30] = True  # half of what is predicted
        masks[truth == MOVED] = moved
        both, first = rng.uniform(size=(2, N)) < 0.5
        arrays = dict(
            pictures=pictures,
            masks=pack_masks(masks),
            outcome=truth.astype(np.int8),
            kind=np.arange(N, dtype=np.int8) % 2,
            touched_fixed=both | first,
            touched_fixed_first=first,
        )
        known[run.name] = {"said": said, **arrays}
        files[run.name] = [folder / f"{run.name}.{i}.h5" for i in range(tuple_jobs(config))]
        for i, path in enumerate(files[run.name]):
            write_arrays(
                path,
                mask_scores.CONTENT,
                {name: array[i * PER_JOB : (i + 1) * PER_JOB] for name, array in arrays.items()},
                {},
            )
    return files, known


def killed_and_resumed(stage, write, out, monkeypatch, dies_at: int) -> int:
    """Run a stage with a predictor that dies once, then go on; returns how often the second predictor was asked."""
    monkeypatch.setattr(stage, "load_predictor", lambda *_: Obedient(dies_at))
    with pytest.raises(Killed):
        write()
    assert not out.exists()
    second = Obedient()
    monkeypatch.setattr(stage, "load_predictor", lambda *_: second)
    write()
    assert list(out.parent.glob(f".{out.name}*")) == []
    return second.asked


@pytest.fixture
def predictor(tmp_path):
    (tmp_path / "raft.predictor").write_bytes(b"a predictor")
    return tmp_path / "raft.predictor"


def test_scores_are_of_the_first_tuples_through_the_right_camera(
    config, played, predictor, tmp_path, monkeypatch
):
    (files, known), out = played, tmp_path / "scores.parquet"
    asked = killed_and_resumed(
        mask_scores,
        lambda: mask_scores.write_model_scores(config, predictor, "raft", files, out),
        out,
        monkeypatch,
        6,
    )
    assert (
        0 < asked < sum(len(run.sets) for run in tuple_runs(config).values()) * tuple_jobs(config)
    )  # what was done is not done again
    table = read_table("mask_scores", out)
    for run in tuple_runs(config).values():
        for k, test_set in enumerate(run.sets):
            rows = table[table["test_set"] == test_set]
            said, truth = known[run.name]["said"][:, k, 0], known[run.name]["outcome"][:, k, 0]
            wanted = np.sort(np.concatenate([np.nonzero(truth == o)[0][:2] for o in range(3)]))
            assert rows["experiment"].tolist() == wanted.tolist()
            assert rows["household"].tolist() == (wanted // PER_JOB).tolist() and rows[
                "kind"
            ].tolist() == [KINDS[i % 2] for i in wanted]
            assert rows["outcome_true"].tolist() == [OUTCOMES[o] for o in truth[wanted]]
            assert rows["outcome_predicted"].tolist() == [OUTCOMES[o] for o in said[wanted]]
            right = rows[(rows["outcome_true"] == "moved") & (rows["outcome_predicted"] == "moved")]
            assert (
                (right[["iou_1", "iou_2"]] == 0.5).all(axis=None)
                and (right["intersection"] == 400).all()
                and (right["union"] == 800).all()
            )


def test_alternatives_are_those_of_every_experiment(
    config, played, predictor, tmp_path, monkeypatch
):
    (files, known), out = played, tmp_path / "alternatives.parquet"

    def write():
        mask_alternatives.write_alternatives(config, predictor, files["as-trained"], out)

    assert killed_and_resumed(mask_alternatives, write, out, monkeypatch, 4) == len(
        COMPARISONS
    )  # the second of two households
    table, arrays = read_table("mask_alternatives", out), known["as-trained"]
    assert len(table) == N * len(COMPARISONS)
    for k, comparison in enumerate(COMPARISONS):
        rows = table[table["comparison"] == comparison]
        assert rows["experiment"].tolist() == list(range(N)) and rows["household"].tolist() == [
            i // PER_JOB for i in range(N)
        ]
        assert rows["outcome_true"].tolist() == [OUTCOMES[o] for o in arrays["outcome"][:, 0, k]]
        assert rows["outcome_predicted"].tolist() == [OUTCOMES[o] for o in arrays["said"][:, 0, k]]
        assert (rows["touched"].to_numpy() == arrays["touched_fixed"]).all()
        assert (rows["touched_first"].to_numpy() == arrays["touched_fixed_first"]).all()
        right = rows[(rows["outcome_true"] == "moved") & (rows["outcome_predicted"] == "moved")]
        assert (right["overlap"] == 0.5).all()


def test_the_local_scp_is_that_of_each_place(config, predictor, tmp_path, monkeypatch):
    files, called = (
        [],
        np.random.default_rng(0).integers(3, size=(2, 4, 3)),
    )  # files, places, experiments
    for i, of_file in enumerate(called):
        pictures = np.zeros((12, 2, SIZE, SIZE, 3), np.uint8)
        pictures[:, 0, 0, 0, 0] = of_file.ravel()
        arrays = dict(
            pictures=pictures,
            different=np.zeros((4, 3), bool),
            pose=np.arange(12.0).reshape(4, 3) + 12 * i,
            clearance=np.array([-0.1, 0.2, -0.1, 0.2]),
            over_low=np.array([True, True, False, False]),
        )
        files.append(tmp_path / f"{i}.h5")
        about = dict(
            dof="shoulder-pan",
            rooms=json.dumps(["a", "b", "c", "d"]),
            nearest=json.dumps(["wall", "", "wall", ""]),
        )
        write_arrays(files[-1], local_scp.CONTENT, arrays, about)
    out = tmp_path / "local_scp.parquet"
    assert (
        killed_and_resumed(
            local_scp,
            lambda: local_scp.write_local_scp(config, files, predictor, out),
            out,
            monkeypatch,
            2,
        )
        == 1
    )
    table = read_table("local_scp", out)
    different = (called == DIFFERENT).sum(2).ravel()
    assert table["different"].tolist() == different.tolist() and table[
        "scp"
    ].tolist() == pytest.approx(1 - different / 3)
    assert (
        table["x"].tolist() == [3.0 * i for i in range(8)]
        and table["room"].tolist() == list("abcd") * 2
    )
    assert (
        table["within_reach"].tolist() == [True, False] * 4
        and table["over_low"].tolist() == [False, True, False, False] * 2
    )
    assert (table["scp_true"] == 1).all()
    other = validate(merge(config.model_dump(mode="json"), {"masks": {"map": {"experiments": 6}}}))
    with pytest.raises(
        ArrayFileError, match="3 experiments at a place, where the configuration asks for 6"
    ):
        local_scp.write_local_scp(other, files, predictor, out)


def test_a_stage_starts_anew_with_another_predictor(
    config, played, predictor, tmp_path, monkeypatch
):
    out = tmp_path / "alternatives.parquet"

    def write():
        mask_alternatives.write_alternatives(config, predictor, played[0]["as-trained"], out)

    monkeypatch.setattr(mask_alternatives, "load_predictor", lambda *_: Obedient(4))
    with pytest.raises(Killed):
        write()
    predictor.write_bytes(b"another predictor")
    second = Obedient()
    monkeypatch.setattr(mask_alternatives, "load_predictor", lambda *_: second)
    write()
    assert second.asked == 2 * len(COMPARISONS)
