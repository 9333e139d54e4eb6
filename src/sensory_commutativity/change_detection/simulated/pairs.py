"""Labelled pairs of pictures, made without playing experiments (paper, section IV-A, "Training").

The pairs imitate what SC-experiments end in. Light, exposure and noise differ between the two
pictures of every pair. Robots that come back do so exactly or almost, objects move by millimetres
or metres, and the arm is in view, sometimes as all that moved. In some pairs the camera is turned
away from its usual direction, so that all of the arm comes into view.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...errors import UserError
from ...worlds.apartment import frames as fr
from ...worlds.apartment.scenes.scene import SEGMENTATION_IDS
from ..outcome import MIN_VISIBLE_PIXELS, Outcome, displaced_objects, label_pair
from .perturbations import ROBOT_MOTIONS, perturb_objects, perturb_robot_pose, return_robot
from .photometric import JITTER, apply_camera_noise, jitter_camera, sample_light
from .robot_placement import place_robot_anywhere
from .scene_sampler import SceneSampler, View

PAIRS_PER_LAYOUT = 100
"""Situations with the same layout of objects. Chosen: a layout takes as long as some five pairs."""
STILL_CAMERA_FRACTION = 0.5
"""Fraction of the pairs of a robot that came back in which the camera did not move. Chosen: as in
most SC-experiments with an arm."""
FORWARD_GAZE_FRACTION = 0.6
"""Fraction of the pairs in which the camera points as in SC-experiments. Chosen."""
MAX_GAZE_ANGLE = math.radians(22.5)
"""Radians by which it is turned in the others, at most, about each axis. Chosen: up to the edge of
what a camera with twice the field of view, 90 degrees, sees."""
ROBOT_TRIES = 60
"""Poses that are tried for a robot that moved before another situation is sampled. Chosen."""
MAX_SITUATIONS = 3_000
"""Situations that are tried for one pair. Chosen: a hundred times what the apartments of this
package need."""


class Pair(NamedTuple):
    """Two pictures and what moved between them.

    Attributes
    ----------
    pictures : uint8 (2, h, w, 3)
        RGB.
    masks : bool (2, h, w)
        Pixels that show something that moved.
    outcome : str
    kind : str
        How the pair was made: "still" or "jitter" (of the camera; *identical*), "turned",
        "almost", "elsewhere" or "arm" (see :data:`.perturbations.RobotMotion`; *different*), or
        "moved".
    """

    pictures: np.ndarray
    masks: np.ndarray
    outcome: Outcome
    kind: str


class PairFactory:
    """Makes pairs of pictures through the first camera of a scene sampler."""

    def __init__(self, sampler: SceneSampler):
        self.sampler = sampler
        self.simulation = sampler.simulation
        self.rng = sampler.rng
        self.camera = sampler.cameras[0]
        self._gaze = np.eye(4)

    def make_pair(self, outcome: Outcome) -> Pair:
        """Make a pair with the given outcome; try other situations until it has it.

        Raises UserError if none of MAX_SITUATIONS does.
        """
        make = {
            "identical": self._make_identical,
            "different": self._make_different,
            "moved": self._make_moved,
        }[outcome]
        for _ in range(MAX_SITUATIONS):
            self.sampler.sample_situation(PAIRS_PER_LAYOUT)
            self._gaze = self._sample_gaze()
            pair = make()
            if pair is not None and pair.outcome == outcome:
                return pair
        raise UserError(
            f"scene {self.sampler.scene.name!r}: none of {MAX_SITUATIONS} situations gives a pair "
            f"of pictures with the outcome {outcome!r}; use more objects or another camera pose"
        )

    # ---- one method per outcome ----------------------------------------------------------------

    def _make_identical(self) -> Pair:
        first, before = self._render(), self.simulation.objects.poses()
        if self.rng.uniform() < 0.2:  # objects that move by less than a centimetre did not move
            for i in self._sample_visible_objects(first)[:1]:
                nudge = self.rng.uniform(-0.005, 0.005, 2)
                self.simulation.objects.place(int(i), before[i] + [*nudge, 0, 0, 0, 0, 0])
        jitter = self._return_robot()
        displaced = displaced_objects(before, self.simulation.objects.poses())
        kind = "jitter" if jitter else "still"
        return self._finish(first, self._render(jitter), displaced, kind)

    def _make_different(self) -> Pair | None:
        simulation, rng = self.simulation, self.rng
        first = self._render()
        motion = tuple(ROBOT_MOTIONS)[rng.choice(len(ROBOT_MOTIONS), p=[*ROBOT_MOTIONS.values()])]
        if motion == "elsewhere":
            place_robot_anywhere(simulation, rng)
            return self._finish(first, self._render(), np.array([], int), motion)
        base, joints, before = simulation.base(), simulation.joints(), simulation.objects.poses()
        if rng.uniform() < 0.3:  # a robot that was stopped by a wall often pushed an object, too
            self._perturb_objects(first, before)
        for _ in range(ROBOT_TRIES):
            base_pose, bent = perturb_robot_pose(motion, base.copy(), joints.copy(), rng)
            if simulation.fits(base_pose, simulation.robot.clip_joints(bent)):
                displaced = displaced_objects(before, simulation.objects.poses())
                return self._finish(first, self._render(), displaced, motion)
        return None

    def _make_moved(self) -> Pair | None:
        first, before = self._render(), self.simulation.objects.poses()
        if not self._perturb_objects(first, before):
            return None
        displaced = displaced_objects(before, self.simulation.objects.poses())
        return self._finish(first, self._render(self._return_robot()), displaced, "moved")

    # ---- helpers -------------------------------------------------------------------------------

    def _sample_gaze(self) -> np.ndarray:
        """Sample how the camera of both pictures is turned from its mount: float64 (4, 4)."""
        if self.rng.uniform() < FORWARD_GAZE_FRACTION:
            return np.eye(4)
        yaw, pitch = self.rng.uniform(-MAX_GAZE_ANGLE, MAX_GAZE_ANGLE, 2)
        z_axis, y_axis = np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0])
        return fr.rotation(z_axis, yaw) @ fr.rotation(y_axis, pitch)

    def _render(self, jitter: float = 0.0) -> View:
        """Render the present situation; `jitter` as in :func:`.photometric.jitter_camera`."""
        camera_pose = self.simulation.camera_pose() @ self._gaze
        if jitter:
            camera_pose = jitter_camera(camera_pose, jitter, self.rng)
        return self.sampler.render_view(camera_pose, sample_light(self.rng))

    def _return_robot(self) -> float:
        """Let the robot come back; return the scale, degrees, of the camera's jitter."""
        return_robot(self.simulation, self.rng)
        return 0.0 if self.rng.uniform() < STILL_CAMERA_FRACTION else JITTER

    def _perturb_objects(self, first: View, before: np.ndarray) -> bool:
        return perturb_objects(self.sampler, self._sample_visible_objects(first), before)

    def _sample_visible_objects(self, view: View) -> np.ndarray:
        """Indices of the visible objects in random order, larger ones earlier: int (k,).

        Each next one is drawn with a probability proportional to the pixels that it covers, by
        exponential clocks (Efraimidis and Spirakis 2006, doi:10.1016/j.ipl.2005.11.003).
        """
        ids = view.pictures[0].segmentation  # 1 + i for object i
        object_ids = np.where(ids < SEGMENTATION_IDS["fixture"], ids, 0)  # 0: no object
        n_objects = len(self.sampler.scene.movables)
        pixels = np.bincount(object_ids.ravel(), minlength=n_objects + 1)[1:]
        visible = np.nonzero(pixels >= MIN_VISIBLE_PIXELS)[0]
        clocks = self.rng.exponential(size=len(visible)) / pixels[visible]
        return visible[np.argsort(clocks)]

    def _finish(self, first: View, second: View, displaced: np.ndarray, kind: str) -> Pair:
        """Label two views, put them in random order, and add camera noise."""
        a, b = first.pictures[0], second.pictures[0]
        poses = first.camera_pose, second.camera_pose
        outcome, masks = label_pair(a, b, *poses, displaced, self.camera)
        pictures = [a, b]
        if self.rng.uniform() < 0.5:
            pictures, masks = pictures[::-1], masks[::-1]
        noisy = [apply_camera_noise(picture.rgb, self.rng) for picture in pictures]
        return Pair(np.stack(noisy), np.ascontiguousarray(masks), outcome, kind)
