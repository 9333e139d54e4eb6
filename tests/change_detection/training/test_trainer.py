"""The training loop: learning rate, interruption and resumption."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from sensory_commutativity.change_detection.training import trainer as trainer_module
from sensory_commutativity.change_detection.training.trainer import (
    Trainer,
    TrainingSettings,
    get_lr,
)
from sensory_commutativity.storage.checkpoints import Checkpoint

SETTINGS = TrainingSettings(samples=40, batch_size=4, learning_rate=0.01)


def test_the_learning_rate_rises_and_falls():
    settings = TrainingSettings(samples=4800, learning_rate=0.01)
    rates = np.array([get_lr(settings, step) for step in range(settings.steps)])
    top = int(np.argmax(rates))
    assert max(rates) == pytest.approx(0.01) and 0 < top < 20 and rates[-1] < 1e-5
    assert all(np.diff(rates[: top + 1]) > 0) and all(np.diff(rates[top + 1 :]) < 0)


class Regression(Trainer):
    """Fits a line to noise that depends on the step, and can be interrupted."""

    def __init__(self, interrupt_at: int | None = None):
        torch.manual_seed(0)
        super().__init__(torch.nn.Linear(3, 1), SETTINGS)
        self.interrupt_at = interrupt_at

    def compute_loss(self) -> torch.Tensor:
        if self.step == self.interrupt_at:
            raise KeyboardInterrupt
        x = torch.randn(4, 3, generator=torch.Generator().manual_seed(self.step))
        return (self.model(x) - x.sum(1, keepdim=True)).square().mean()


def test_an_interrupted_run_resumes_and_ends_with_the_same_weights_and_rows(tmp_path, monkeypatch):
    def fit(trainer: Regression, name: str) -> list[dict[str, float]]:
        def evaluate(rows):
            return dict(number=len(rows), step=trainer.step, loss=trainer.losses[-1])

        return trainer.fit(Checkpoint(tmp_path / name, "settings"), name, [4, 10], evaluate)

    uninterrupted = Regression()
    rows = fit(uninterrupted, "whole")
    assert [(row["number"], row["step"]) for row in rows] == [(0, 4), (1, 10)]
    assert uninterrupted.losses[-1] != uninterrupted.losses[0]
    monkeypatch.setattr(trainer_module, "CHECKPOINT_SECONDS", 0.0)
    for interrupt_at in (2, 6):
        with pytest.raises(KeyboardInterrupt):
            fit(Regression(interrupt_at), "interrupted")
    resumed = Regression()
    assert fit(resumed, "interrupted") == rows
    assert len(resumed.losses) == SETTINGS.steps
    assert torch.equal(resumed.model.weight, uninterrupted.model.weight)
