"""Pairs of pictures to learn from (paper, section IV-A, "Dataset", and appendix D).

The unit is a cluttered scene: one set of objects, in several layouts, with a random stream of its
own.
"""

from __future__ import annotations

from typing import Any

from ...config import Config
from ...declarations import Shard, Shards, arrays
from ..builders import count_pair_scenes, data_settings, make_pair_sampler, pairs_in_scene


@arrays(
    title="Pairs of pictures for training and validation",
    shards=Shards(
        runs=count_pair_scenes,
        settings=lambda config, split: [
            data_settings(config),
            pairs_in_scene(config, split, count_pair_scenes(config)[split] - 1),
        ],
        per_shard=lambda config: config.masks.data.scenes_per_job,
    ),
)  # fmt: skip
def mask_pairs(config: Config, shard: Shard) -> tuple[dict[str, Any], dict[str, str]]:
    """The pairs of some scenes, in turn of each outcome."""
    from ....change_detection.outcome import OUTCOMES
    from ....change_detection.pair_files import pairs_to_arrays
    from ....change_detection.simulated.pairs import PairFactory
    from ....progress import progress

    pairs, scenes = [], []
    for scene in range(shard.start, shard.stop):
        factory = PairFactory(make_pair_sampler(config, shard.run, scene))
        n = pairs_in_scene(config, shard.run, scene)
        for _ in progress(range(n), f"{shard.name}, scene {scene}", "triple"):
            pairs += [factory.make_pair(outcome) for outcome in OUTCOMES]
        scenes += [scene] * n * len(OUTCOMES)
    return pairs_to_arrays(pairs, scenes)
