"""A planar arm that pushes a puck, beside joints that reach nothing, as a Gymnasium environment.

Three joints move the arm; three more turn a mast with a camera, which touches nothing. It is a
small task on which an action space chosen by SCP can be compared with others.
"""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium import spaces

ENVIRONMENT_ID = "SensoryCommutativity/PlanarArm-v0"
MAX_EPISODE_STEPS = 50
"""Steps after which an episode is truncated. Chosen: the arm crosses its workspace twice."""
ARM = ("shoulder", "elbow", "wrist")
MAST = ("pan", "tilt", "roll")
SPEED = 0.1
"""How far an action of 1 moves the target of a joint, rad. Chosen: as in the apartment."""
LIMIT = 2.6
"""Stops of all joints, rad, on both sides. Chosen: two links next to each other do not meet."""
SUBSTEPS = 5
"""Simulator steps of 10 ms in a step. Chosen."""
START = 0.5
"""Joints start within so many rad of 0. Chosen."""
DISTANCE, BEARING = (0.2, 0.4), 1.5
"""Where the puck starts: metres from the shoulder, and largest angle, rad. Chosen: in reach."""
PROGRESS, APPROACH = 10.0, 0.1
"""Reward for a metre that the puck is pushed away from its start, and cost of a metre between tip
and puck in a step. Chosen: reaching the puck is worth less than pushing it by 5 cm."""

_JOINT = 'type="hinge" limited="true" range="-2.6 2.6" armature="0.02" damping="0.5"'
_MODEL = f"""
<mujoco model="planar arm">
  <compiler angle="radian" autolimits="true"/>
  <option timestep="0.01" gravity="0 0 0" integrator="implicitfast"/>
  <default>
    <geom contype="0" conaffinity="0" density="300" rgba=".3 .4 .6 1"/>
    <position kp="20" kv="2"/>
  </default>
  <worldbody>
    <light pos="0 0 2"/>
    <camera name="above" pos=".15 0 1.3"/>
    <geom name="table" type="plane" size=".7 .7 .1" pos="0 0 -.04" rgba=".9 .9 .9 1"/>
    <body name="link1">
      <joint name="shoulder" axis="0 0 1" {_JOINT}/>
      <geom name="link1" type="capsule" fromto="0 0 0 .15 0 0" size=".02" contype="1"/>
      <body name="link2" pos=".15 0 0">
        <joint name="elbow" axis="0 0 1" {_JOINT}/>
        <geom name="link2" type="capsule" fromto="0 0 0 .15 0 0" size=".02" contype="1"/>
        <body name="link3" pos=".15 0 0">
          <joint name="wrist" axis="0 0 1" {_JOINT}/>
          <geom name="link3" type="capsule" fromto="0 0 0 .12 0 0" size=".02" contype="1"/>
          <site name="tip" pos=".12 0 0"/>
        </body>
      </body>
    </body>
    <body name="mast" pos="-.15 0 .2">
      <joint name="pan" axis="0 0 1" {_JOINT}/>
      <geom type="cylinder" size=".02 .1"/>
      <body name="head" pos="0 0 .1">
        <joint name="tilt" axis="0 1 0" {_JOINT}/>
        <joint name="roll" axis="1 0 0" {_JOINT}/>
        <geom type="box" size=".04 .02 .02"/>
      </body>
    </body>
    <body name="puck">
      <joint name="puck-x" type="slide" axis="1 0 0" damping="1" frictionloss=".05"/>
      <joint name="puck-y" type="slide" axis="0 1 0" damping="1" frictionloss=".05"/>
      <geom name="puck" type="cylinder" size=".03 .03" conaffinity="1" rgba=".8 .3 .1 1"/>
    </body>
  </worldbody>
  <actuator>
    {"".join(f'<position name="{name}" joint="{name}"/>' for name in (*ARM, *MAST))}
  </actuator>
</mujoco>
"""


class PlanarArmEnv(gym.Env):
    """An arm of three joints pushes a puck as far as it can; three other joints turn a camera mast.

    Action Space
    ------------
    ``Box(-1, 1, (6,), float32)``: shoulder, elbow, wrist, pan, tilt, roll. An action of 1 moves
    the joint by 0.1 rad in one step; targets stay within 2.6 rad of the middle.

    Observation Space
    -----------------
    ``Box(-inf, inf, (26,), float64)``: sines (6) and cosines (6) of the joints, their velocities
    (6, rad/s), the puck (x, y, m), its velocity (x, y, m/s), the puck from the tip (x, y, m), the
    puck from where it started (x, y, m).

    Rewards
    -------
    10 for each metre that the puck comes farther from where it started, less 0.1 for each metre
    between tip and puck.

    Starting State
    --------------
    Joints uniform in [-0.5, 0.5] rad; the puck at 0.2 to 0.4 m from the shoulder, at most 1.5 rad
    to either side.

    Episode End
    -----------
    Truncated after 50 steps; never terminated.

    Parameters
    ----------
    render_mode : {None, "rgb_array"}
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 20}  # noqa: RUF012  (Gymnasium's form)

    def __init__(self, render_mode: str | None = None):
        import mujoco

        self.render_mode = render_mode
        self.model = mujoco.MjModel.from_xml_string(_MODEL)
        self.data = mujoco.MjData(self.model)
        self.action_space = spaces.Box(-1.0, 1.0, (self.model.nu,), np.float32)
        self.observation_space = spaces.Box(-np.inf, np.inf, (26,), np.float64)
        self.target = np.zeros(self.model.nu)
        self.puck_start = np.zeros(2)
        self._renderer: Any = None

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        import mujoco

        super().reset(seed=seed)
        mujoco.mj_resetData(self.model, self.data)
        n = self.model.nu
        self.target = self.np_random.uniform(-START, START, n)
        distance = self.np_random.uniform(*DISTANCE)
        bearing = self.np_random.uniform(-BEARING, BEARING)
        self.puck_start = distance * np.array([np.cos(bearing), np.sin(bearing)])
        self.data.qpos[:n], self.data.qpos[n:] = self.target, self.puck_start
        self.data.ctrl[:] = self.target
        mujoco.mj_forward(self.model, self.data)
        return self._observation(), {}

    def step(self, action: np.ndarray) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        import mujoco

        before = self._displacement()
        moved = self.target + SPEED * np.clip(action, -1.0, 1.0)
        self.target = np.clip(moved, -LIMIT, LIMIT)
        self.data.ctrl[:] = self.target
        mujoco.mj_step(self.model, self.data, SUBSTEPS)
        observation, displacement = self._observation(), self._displacement()
        reach = float(np.hypot(*observation[22:24]))
        reward = PROGRESS * (displacement - before) - APPROACH * reach
        return observation, reward, False, False, {"displacement": displacement}

    def render(self) -> np.ndarray:
        """A picture from above, uint8 (480, 640, 3)."""
        import mujoco

        if self._renderer is None:
            self._renderer = mujoco.Renderer(self.model, 480, 640)
        self._renderer.update_scene(self.data, "above")
        return self._renderer.render()

    def close(self) -> None:
        if self._renderer is not None:
            self._renderer.close()

    def _displacement(self) -> float:
        """How far the puck is from where it started, m."""
        return float(np.hypot(*(self.data.qpos[-2:] - self.puck_start)))

    def _observation(self) -> np.ndarray:
        n, qpos, qvel = self.model.nu, self.data.qpos, self.data.qvel
        puck = qpos[n:]
        tip = self.data.site_xpos[0, :2]
        parts = (np.sin(qpos[:n]), np.cos(qpos[:n]), qvel[:n], puck, qvel[n:], puck - tip,
                 puck - self.puck_start)  # fmt: skip
        return np.concatenate(parts)


if ENVIRONMENT_ID not in gym.registry:
    gym.register(
        ENVIRONMENT_ID,
        entry_point="sensory_commutativity.worlds.planar_arm:PlanarArmEnv",
        max_episode_steps=MAX_EPISODE_STEPS,
    )
