"""Training curves of the models that find what changed (paper, section IV-A, "Architecture and
training")."""

from __future__ import annotations

from pathlib import Path
from typing import NoReturn

from ....errors import UserError
from ....storage.columns import FLOAT, INT, Column
from ...config import Config
from ...declarations import Expected, Shards, table
from ..builders import trained_models, training_settings
from ..columns import MODEL


@table(
    title="Training curves of the mask models",
    columns=(
        MODEL,
        Column("step", INT, "1", "training steps done", key=True),
        Column("samples", INT, "1", "pairs shown, with repetitions"),
        Column("learning_rate", FLOAT, "1", "at that step"),
        Column("loss", FLOAT, "1", "mean since the previous row", nullable=True),
        Column(
            "accuracy", FLOAT, "1",
            "of the three outcomes on the validation pairs, with default decision thresholds",
            nullable=True, low=0, high=1,
        ),
        Column(
            "iou", FLOAT, "1",
            "mean intersection over union on the validation pairs in which something moved",
            nullable=True, low=0, high=1,
        ),
    ),
    inputs=["mask_pairs/training", "mask_pairs/validation"],
    shards=Shards(runs=trained_models, settings=training_settings),
    expected=lambda config: Expected(
        ("model",), {(name,): None for name in trained_models(config)}
    ),
    expected_shard=lambda config, shard: Expected(("model",), {(shard.run,): None}),
)  # fmt: skip
def mask_curves(training: list[Path], validation: list[Path], config: Config, run: str) -> NoReturn:
    """The curve of one model, which training writes. Raises UserError."""
    raise UserError(f"training writes its curve itself: train mask_training --run {run}")
