"""Animation of a trained agent: the first evaluation episodes from above, and what the eye sees."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd

from ...config import Config
from ...declarations import Shards, animation
from ...plotting import GifWriter

if TYPE_CHECKING:
    from ....navigation.action_spaces import ScaledAction

FRAMES_PER_SECOND = 10
LAST_FRAMES = 12
"""How often the last frame of an episode is repeated."""
EPISODES = 3
ALL_STEPS, EVERY = 40, 4
"""After so many steps only every fourth is shown: an episode that runs out of time is long."""


class Frame(NamedTuple):
    """What is drawn.

    Attributes
    ----------
    view : uint8 (pixels, 3)
    trail : list of float64 (2,)
        Positions of the base so far.
    text : str
    repeat : int
        How often the frame is repeated.
    """

    view: np.ndarray
    trail: list[np.ndarray]
    text: str
    repeat: int


def median_seed(scores: pd.DataFrame, action_space: str) -> int:
    """The run of an action space with the (lower) median area under its learning curve."""
    runs = scores[scores["action_space"] == action_space].sort_values(["auc", "seed"])
    return int(runs["seed"].iloc[(len(runs) - 1) // 2])


def _inputs(config: Config, action_space: str | None) -> list[str]:
    seeds = config.navigation.seeds
    return ["navigation_scores", *(f"navigation_policy/{action_space}.{seed}" for seed in seeds)]


@animation(
    title="Evaluation episodes of the median run of an action space",
    inputs=_inputs,
    shards=Shards(
        runs=lambda config: dict.fromkeys(config.navigation.action_spaces, 1),
        settings=lambda config, run: None,
    ),
)
def navigation_episode(scores: pd.DataFrame, *arguments) -> None:
    """Write the animation as a GIF.

    `arguments` are the files of the policies of all seeds, the configuration, the action space and
    the file to write.
    """
    from ....navigation.action_spaces import ScaledAction
    from ....storage.checkpoints import load_state
    from ....worlds.flatland.drawing import draw_room, draw_view
    from ..builders import evaluation_seeds, navigation_environment, trained_policy

    *policies, config, action_space, out = arguments
    seed = median_seed(scores, action_space)
    path = policies[config.navigation.seeds.index(seed)]
    model = load_state(path, "run the workflow")
    policy = trained_policy(config, model, str(path))
    environment = navigation_environment(config)
    wrapped = ScaledAction(environment, list(model["scales"].values()))
    figure, (room, view) = plt.subplots(2, 1, figsize=(4.2, 4.9), height_ratios=[14, 1])
    figure.subplots_adjust(left=0.03, right=0.97, bottom=0.03, top=0.86, hspace=0.14)

    def draw(frame: Frame, episode: int) -> None:
        for panel in (room, view):
            panel.clear()
        draw_room(room, environment.world)
        for zone in environment.zones:
            room.text(
                zone.x, zone.y, f"{zone.reward:+g}", ha="center", va="center", fontsize=9, zorder=8
            )
        trail = np.array(frame.trail).T
        room.plot(*trail, color="#333333", linewidth=1, linestyle=":", zorder=2)
        draw_view(view, frame.view)
        view.set_title("what the eye sees", fontsize=7, pad=2)
        title = f"{action_space}, run {seed} (median)\nepisode {episode}: {frame.text}"
        figure.suptitle(title, fontsize=10)

    with GifWriter(figure, out, config, FRAMES_PER_SECOND, dpi=80) as film:
        for episode, start in enumerate(evaluation_seeds(config)[:EPISODES], 1):
            for frame in _play_episode(policy, wrapped, start):
                draw(frame, episode)
                for _ in range(frame.repeat):
                    film.grab_frame()


def _play_episode(policy, environment: ScaledAction, seed: int) -> Iterator[Frame]:
    """Play an episode with the mean action of the policy; yield the frames to draw."""
    world = environment.unwrapped.world  # type: ignore[attr-defined]  # a NavigationEnv
    view, _ = environment.reset(seed=seed)
    state, start, step, ended = None, np.ones(1, bool), 0, False
    trail = [world.poses()[0, :2]]
    yield Frame(view, trail, "step 0", 1)
    while not ended:
        action, state = policy.predict(view[None], state, start, deterministic=True)
        start = np.zeros(1, bool)
        view, reward, terminated, truncated, _ = environment.step(action[0])
        step, ended = step + 1, terminated or truncated
        trail.append(world.poses()[0, :2])
        if ended or step <= ALL_STEPS or step % EVERY == 0:
            outcome = ""
            if terminated:
                outcome = f", return {reward:+g}"
            elif truncated:
                outcome = ", out of time"
            yield Frame(view, trail, f"step {step}{outcome}", LAST_FRAMES if ended else 1)
