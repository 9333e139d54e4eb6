"""Flatland as a Gymnasium environment."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium import spaces

from .agent import Polyphemus
from .room import Room
from .world import FlatlandWorld

ENVIRONMENT_ID = "SensoryCommutativity/Flatland-v0"
MAX_EPISODE_STEPS = 300
"""Steps after which an episode is truncated. Chosen: enough to cross the room several times."""


def action_space(agent: Polyphemus) -> spaces.Box:
    """One element in [-1, 1] per degree of freedom."""
    return spaces.Box(-1.0, 1.0, (len(agent.dofs),), np.float32)


def observation_space(agent: Polyphemus) -> spaces.Box:
    """RGB pixels, uint8 (pixels, 3)."""
    return spaces.Box(0, 255, (agent.pixels, 3), np.uint8)


class FlatlandEnv(gym.Env):
    """Polyphemus in a room, without a task.

    Description
    -----------
    A one-eyed agent with two arms moves among fixed, movable and moving objects (paper, section
    III-A). The environment has no task of its own; it is a base class for tasks.

    Action Space
    ------------
    ``Box(-1, 1, (8,), float32)``; an action of 1 moves, in one step:

    ===  =================  ==========  =====
    Num  Action             Full speed  Unit
    ===  =================  ==========  =====
    0    base-longitudinal  8           units
    1    base-rotation      0.25        rad
    2    head               0.25        rad
    3    eyelid             0.05        1
    4    left-shoulder      0.25        rad
    5    left-elbow         0.25        rad
    6    right-shoulder     0.25        rad
    7    right-elbow        0.25        rad
    ===  =================  ==========  =====

    Observation Space
    -----------------
    ``Box(0, 255, (64, 3), uint8)``: RGB pixels over 90 degrees, from right to left. Chipmunk
    integrates positions with the velocity of the previous sub-step: the last quarter of a motion of
    the base or the arms becomes visible one step later.

    Rewards
    -------
    Always 0.

    Starting State
    --------------
    A new room with new objects, and the agent at a random free pose in it, at rest; head straight
    ahead, eyelid half open, arms mid-range.

    Episode Truncation
    ------------------
    After 300 steps, when made through ``gymnasium.make``. Episodes never terminate.

    Arguments
    ---------
    room : Room, optional
    agent : Polyphemus, optional
    render_mode : None or ``"rgb_array"``
        The room from above, uint8 (height, width, 3).

    Version History
    ---------------
    v0: first version.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 10}  # noqa: RUF012  (Gymnasium's form)

    def __init__(
        self,
        room: Room | None = None,
        agent: Polyphemus | None = None,
        render_mode: str | None = None,
    ):
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise ValueError(
                f"render_mode must be None or one of {self.metadata['render_modes']}, "
                f"got {render_mode!r}"
            )
        self.world = FlatlandWorld(room, agent)
        self.render_mode = render_mode
        self.action_space = action_space(self.world.agent)
        self.observation_space = observation_space(self.world.agent)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        super().reset(seed=seed)
        self.world.reset(self.np_random)
        return self.world.observe(), {}

    def step(self, action: np.ndarray) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        self.world.step(action)
        return self.world.observe(), 0.0, False, False, {}

    def render(self) -> np.ndarray | None:
        if self.render_mode is None:
            return None
        from matplotlib.backends.backend_agg import FigureCanvasAgg  # slow to import
        from matplotlib.figure import Figure

        from .drawing import draw_room

        canvas = FigureCanvasAgg(Figure(figsize=(4.8, 6.4), dpi=100, layout="tight"))
        draw_room(canvas.figure.add_subplot(), self.world)
        canvas.draw()
        return np.asarray(canvas.buffer_rgba())[..., :3].copy()


if ENVIRONMENT_ID not in gym.registry:
    gym.register(
        ENVIRONMENT_ID,
        entry_point=f"{__name__}:FlatlandEnv",
        vector_entry_point="sensory_commutativity.worlds.flatland.vector:FlatlandVectorEnv",
        max_episode_steps=MAX_EPISODE_STEPS,
    )
