"""Noise of one kind at several levels, as runs of experiments."""

from __future__ import annotations

from typing import NamedTuple

from ..config import Config
from .builders import reset_free

SENSOR, ACTUATOR, RESET = "sensor", "actuator", "reset"


class NoiseRun(NamedTuple):
    """A kind of noise under a protocol, ``reset`` or ``return``."""

    noise: str
    protocol: str

    @property
    def name(self) -> str:
        return f"{self.noise}-{self.protocol}"


RUNS = (
    NoiseRun(SENSOR, "reset"), NoiseRun(SENSOR, "return"), NoiseRun(ACTUATOR, "reset"),
    NoiseRun(ACTUATOR, "return"), NoiseRun(RESET, "reset"),
)  # fmt: skip
"""An imperfect reset needs a reset."""


def noise_runs(config: Config) -> dict[str, NoiseRun]:
    """Runs by name; none without a section."""
    if config.reset_free is None:
        return {}
    protocols = config.reset_free.noise.protocols
    return {run.name: run for run in RUNS if run.protocol in protocols}


def noise_levels(config: Config, run: NoiseRun) -> list[float]:
    """Levels of a run, from none to strong."""
    return [0.0, *getattr(reset_free(config).noise, run.noise)]
