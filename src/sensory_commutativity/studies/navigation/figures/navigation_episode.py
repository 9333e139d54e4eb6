"""A trained agent at work, as a film: the first evaluation episodes from above, and what the eye sees."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd

from ....navigation.action_spaces import ScaledAction
from ....navigation.recurrent import RoomPolicy
from ....navigation.task import NavigationEnv
from ....navigation.training import policy_of_run
from ....storage.checkpoints import load_state
from ....storage.tables import atomic_write, read_table
from ....worlds.flatland.drawing import draw_room, draw_view
from ...config import Config
from ...plotting import Film
from ..builders import evaluation_seeds, navigation_environment

FRAMES_PER_SECOND = 10
HOLD = 12  # frames that the end of an episode stands still
EPISODES = 3
WHOLE, EVERY = (
    40,
    4,
)  # after so many steps only every fourth is shown: an episode that runs out of time is long


def typical_seed(scores: pd.DataFrame, action_space: str) -> int:
    """The run in the middle: of all runs of the action space the one with the (lower) median area under its learning curve."""
    runs = scores[scores["action_space"] == action_space].sort_values(["auc", "seed"])
    return int(runs["seed"].iloc[(len(runs) - 1) // 2])


def animate_episode(
    config: Config, action_space: str, scores: Path, models: Path, out: Path
) -> None:
    """Film the first evaluation episodes of the typical run of an action space and save them as a GIF."""
    seed = typical_seed(read_table("navigation_scores", scores), action_space)
    path = models / f"{action_space}.{seed}.policy"
    model = load_state(path, "run the workflow")
    policy = policy_of_run(config, model, str(path))
    environment = navigation_environment(config)
    wrapped = ScaledAction(environment, list(model["scales"].values()))
    figure, (room, view) = plt.subplots(2, 1, figsize=(4.2, 4.9), height_ratios=[14, 1])
    figure.subplots_adjust(left=0.03, right=0.97, bottom=0.03, top=0.86, hspace=0.14)

    def frame(seen: np.ndarray, trail: list[np.ndarray], said: str) -> None:
        for panel in (room, view):
            panel.clear()
        draw_room(room, environment.world)
        for zone in environment.zones:
            room.text(
                zone.x, zone.y, f"{zone.reward:+g}", ha="center", va="center", fontsize=9, zorder=8
            )
        room.plot(*np.array(trail).T, color="#333333", linewidth=1, linestyle=":", zorder=2)
        draw_view(view, seen)
        view.set_title("what the eye sees", fontsize=7, pad=2)
        figure.suptitle(f"{action_space}, run {seed} (median)\n{said}", fontsize=10)

    with atomic_write(out) as temporary:
        writer = Film(FRAMES_PER_SECOND, config)
        with writer.saving(figure, str(temporary), dpi=80):
            for number, start in enumerate(evaluation_seeds(config)[:EPISODES], 1):
                for seen, trail, said, repeat in _episode(policy, wrapped, environment, start):
                    frame(seen, trail, f"episode {number}: {said}")
                    for _ in range(repeat):
                        writer.grab_frame()
    plt.close(figure)


def _episode(
    policy: RoomPolicy, wrapped: ScaledAction, environment: NavigationEnv, seed: int
) -> Iterator[tuple[np.ndarray, list, str, int]]:
    """What is seen, where the base has been, what to write, and how many frames to show it, step by step."""
    seen, _ = wrapped.reset(seed=seed)
    state, start, step, ended = None, np.ones(1, bool), 0, False
    trail = [environment.world.poses()[0, :2]]
    yield seen, trail, "step 0", 1
    while not ended:
        action, state = policy.predict(seen[None], state, start, deterministic=True)
        start = np.zeros(1, bool)
        seen, reward, terminated, truncated, _ = wrapped.step(action[0])
        step, ended = step + 1, terminated or truncated
        trail.append(environment.world.poses()[0, :2])
        if ended or step <= WHOLE or step % EVERY == 0:
            outcome = (
                f", return {reward:+g}" if terminated else ", out of time" if truncated else ""
            )
            yield seen, trail, f"step {step}{outcome}", HOLD if ended else 1
