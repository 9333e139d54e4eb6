"""Pairs of pictures with the three outcomes of an SC-experiment, made without playing one (paper, section IV-A, "Training").

What makes the pairs honest: light, exposure, noise and the camera differ a little between the two pictures of a pair; robots come back almost, not
only exactly or not at all; objects move by centimetres or metres; the robot's arm is in sight, and sometimes it is all that moved. Some robots look
aside, so that all of the arm is seen.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...errors import UserError
from ...worlds.apartment import frames as fr
from ...worlds.apartment.scenes.scene import IDENTITIES
from ..outcome import SEEN, Outcome, outcome_of
from .photometric import JITTER, apply_camera_noise, jitter_camera, sample_light
from .scene_sampler import TRIES, SceneSampler, View, displaced

PAIRS_PER_SCATTER = 100
"""Pairs with the same objects in the same places; chosen: scattering takes as long as some five of them."""
FALL, ROLL = 30, 120
"""Substeps (an eighth and half a second) in which an object that was put down, or pushed, comes to rest."""
NEAR = 0.75
"""Of the pairs, those with the robot's hand beside an object, as in most SC-experiments on objects; the others begin anywhere."""
BY_HAND = 0.5
"""Of the pairs in which something moves, those in which it is what is nearest the hand; chosen: SC-experiments mostly move what they touch."""
STILL = 0.5
"""Of the pairs of a robot that came back, those whose camera is not jitter_camera; chosen: as in most SC-experiments of an arm. In a third of all pairs
of a robot that came back, no joint of it is elsewhere either."""
STRAIGHT = 0.6
"""Of the pairs, those in which the robot looks as it does in SC-experiments; chosen."""
GAZE = math.radians(22.5)
"""How far it looks aside, up or down in the others, at most; chosen: to the edge of what a camera of twice the field of view, 90 degrees, sees."""
ATTEMPTS = 3_000
"""Situations that are tried for one pair; chosen: a hundred times what the apartments here need."""


class Pair(NamedTuple):
    """Two pictures, what moved between them, and how it came about.

    Attributes
    ----------
    pictures : uint8 (2, h, w, 3)
    masks : bool (2, h, w)
    outcome : str
    kind : str
        turned, elsewhere, almost, arm; still, jitter; moved.
    """

    pictures: np.ndarray
    masks: np.ndarray
    outcome: Outcome
    kind: str


class PairFactory:
    """Makes pairs in a household, through the first of its cameras."""

    def __init__(self, household: SceneSampler):
        self.household, self.simulation, self.rng = household, household.simulation, household.rng
        self.camera = household.cameras[0]
        self._since = PAIRS_PER_SCATTER
        self._gaze = np.eye(4)

    def pair(self, outcome: Outcome) -> Pair:
        """A pair with this outcome; situations in which it does not come about are drawn anew."""
        make = {"identical": self._identical, "different": self._different, "moved": self._moved}[
            outcome
        ]
        for _ in range(ATTEMPTS):
            if self._since >= PAIRS_PER_SCATTER:
                self.household.scatter()
                self._since = 0
            if self.rng.uniform() >= NEAR or not self.household.begin_near_an_object():
                self.household.begin()
            self._since += 1
            self._gaze = self._some_gaze()
            made = make()
            if made is not None and made.outcome == outcome:
                return made
        raise UserError(
            f"scene {self.household.scene.name!r}: none of {ATTEMPTS} situations makes a pair of pictures that is {outcome!r}; "
            "let more objects lie about (masks.objects), or the head look elsewhere (masks.fixed)"
        )

    # ---- pictures ----------------------------------------------------------------------------------------------------------

    def _look(self, jitter: float = 0.0) -> View:
        """What is seen; `jitter`, degrees, is the scale of how the camera is turned."""
        eye = self.simulation.eye_pose() @ self._gaze
        return self.household.look(
            jitter_camera(eye, jitter, self.rng) if jitter else eye, sample_light(self.rng)
        )

    def _some_gaze(self) -> np.ndarray:
        """How the camera is turned from where the head points, in both pictures of a pair: float64 (4, 4)."""
        if self.rng.uniform() < STRAIGHT:
            return np.eye(4)
        aside, down = self.rng.uniform(-GAZE, GAZE, 2)
        return fr.turned(np.array([0.0, 0.0, 1.0]), aside) @ fr.turned(
            np.array([0.0, 1.0, 0.0]), down
        )

    def _made(self, first: View, second: View, moved: np.ndarray, kind: str) -> Pair:
        (picture, *_), (other, *_) = first.pictures, second.pictures
        outcome, masks = outcome_of(picture, other, first.eye, second.eye, moved, self.camera)
        if self.rng.uniform() < 0.5:
            picture, other, masks = other, picture, masks[::-1]
        return Pair(
            np.stack(
                [apply_camera_noise(picture.rgb, self.rng), apply_camera_noise(other.rgb, self.rng)]
            ),
            np.ascontiguousarray(masks),
            outcome,
            kind,
        )

    def _back(self) -> float:
        """The robot comes back, more or less: its arm almost where it was in some cases; returns how its camera is to be jitter_camera."""
        simulation, rng = self.simulation, self.rng
        if rng.uniform() < 0.3:
            base, joints = simulation.base(), simulation.joints()
            bends = rng.normal(
                0, math.exp(rng.uniform(math.log(0.002), math.log(0.04))), len(joints)
            )
            bent = joints + bends * (rng.uniform(size=len(joints)) < 0.3)
            simulation.put_robot(base, np.clip(bent, *simulation.robot.limits.T))
        return 0.0 if rng.uniform() < STILL else JITTER

    # ---- outcomes ----------------------------------------------------------------------------------------------------------

    def _identical(self) -> Pair:
        first, before = self._look(), self.simulation.object_poses()
        if self.rng.uniform() < 0.2:  # what moves by less than a centimetre has not moved
            for i in self._seen(first)[:1]:
                nudge = self.rng.uniform(-0.005, 0.005, 2)
                self.simulation.put_object(int(i), before[i] + [*nudge, 0, 0, 0, 0, 0])
        jitter = self._back()
        really = displaced(before, self.simulation.object_poses())
        return self._made(first, self._look(jitter), really, "jitter" if jitter else "still")

    def _different(self) -> Pair | None:
        first, simulation, rng = self._look(), self.simulation, self.rng
        kind = str(rng.choice(["turned", "almost", "elsewhere", "arm"], p=[0.25, 0.5, 0.15, 0.1]))
        if kind == "elsewhere":
            self.household.begin()
            return self._made(first, self._look(), np.array([], int), kind)
        base, joints, before = simulation.base(), simulation.joints(), simulation.object_poses()
        if rng.uniform() < 0.3:  # what pushes against a wall has often pushed something else
            self._move_some(first, before)
        for _ in range(TRIES):
            there, bent = self._elsewhere(kind, base.copy(), joints.copy())
            if simulation.fits(there, np.clip(bent, *simulation.robot.limits.T)):
                return self._made(
                    first, self._look(), displaced(before, simulation.object_poses()), kind
                )
        return None

    def _elsewhere(
        self, kind: str, base: np.ndarray, joints: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Another place of the base or another bend of the arm: turned by 45 degrees and more, by less, or the arm alone."""
        rng = self.rng
        if kind == "turned":
            base[2] += rng.choice([-1, 1]) * (
                math.pi / 2 if rng.uniform() < 0.5 else rng.uniform(math.pi / 4, math.pi)
            )
        elif kind == "almost":
            base[2] += rng.choice([-1, 1]) * math.radians(
                math.exp(rng.uniform(math.log(0.5), math.log(45.0)))
            )
            base[:2] += rng.normal(0, 0.03, 2) * rng.integers(2)
        else:
            bends = rng.choice([-1, 1], len(joints)) * np.exp(
                rng.uniform(math.log(0.01), math.log(1.0), len(joints))
            )
            one = np.arange(len(joints)) == rng.integers(len(joints))
            joints += bends * (one if rng.uniform() < 0.7 else rng.uniform(size=len(joints)) < 0.4)
        return base, joints

    def _moved(self) -> Pair | None:
        first, before = self._look(), self.simulation.object_poses()
        if not self._move_some(first, before):
            return None
        really = displaced(before, self.simulation.object_poses())
        return self._made(first, self._look(self._back()), really, "moved")

    # ---- objects -----------------------------------------------------------------------------------------------------------

    def _seen(self, view: View) -> np.ndarray:
        """Numbers of the objects that are in sight, int (k,), drawn one after the other by how much of the picture they fill
        (exponential clocks: Efraimidis and Spirakis 2006)."""
        identity = view.pictures[0].identity
        counts = np.bincount(
            np.where(identity < IDENTITIES["fixture"], identity, 0).ravel(),
            minlength=len(self.household.scattered) + 1,
        )[1:]
        seen = np.nonzero(counts >= SEEN)[0]
        return seen[np.argsort(self.rng.exponential(size=len(seen)) / counts[seen])]

    def _move_some(self, first: View, before: np.ndarray) -> bool:
        """Displace some of what is seen; what they pushed, but not as far as counts, is put back to the last bit. False if nothing could be moved."""
        simulation, rng = self.simulation, self.rng
        seen = self._seen(first)
        if rng.uniform() < BY_HAND:
            seen = seen[
                np.argsort(
                    np.linalg.norm(before[seen, :3] - self.household.hand(), axis=1), kind="stable"
                )
            ]
        chosen = seen[: int(rng.geometric(0.6))]
        if not len(chosen):
            return False
        moved = [int(i) for i in chosen if self._displace(int(i), before[i])]
        if not moved:
            return False
        nudged = np.setdiff1d(
            np.arange(len(before)), np.union1d(moved, displaced(before, simulation.object_poses()))
        )
        for i in nudged:
            simulation.put_object(int(i), before[i])
        return True

    def _displace(self, i: int, pose: np.ndarray) -> bool:
        """As arms and bases do: pushed, perhaps over or off what it stood on; put elsewhere, by 3 mm to 60 cm or far; or out of sight."""
        rng, base = self.rng, self.simulation.base()
        way = rng.uniform()
        if way < 0.4:
            direction, speed = rng.uniform(-math.pi, math.pi), rng.uniform(0.2, 1.6)
            velocity = np.array([speed * math.cos(direction), speed * math.sin(direction), 0.0])
            self.simulation.put_object(i, pose, velocity, rng.normal(0, 4.0, 3))
            self.simulation.wait(ROLL)
            return True
        if way < 0.6:
            self.household.put_away(i)
            return True
        turn = (
            2 * math.atan2(pose[5], pose[6]) + rng.normal(0, 0.4) if rng.uniform() < 0.5 else None
        )
        for _ in range(TRIES):
            if way < 0.9:
                distance, angle = (
                    math.exp(rng.uniform(math.log(0.003), math.log(0.6))),
                    rng.uniform(-math.pi, math.pi),
                )
                x, y = pose[0] + distance * math.cos(angle), pose[1] + distance * math.sin(angle)
            else:
                distance, angle = rng.uniform(0.5, 3.0), base[2] + rng.uniform(-0.6, 0.6)
                x, y = base[0] + distance * math.cos(angle), base[1] + distance * math.sin(angle)
            if self.household.stand(
                i, x, y, pose[2] + 0.3, lying=rng.uniform() < 0.15, heading=turn
            ):
                self.simulation.wait(FALL)
                return True
        self.simulation.put_object(i, pose)
        return False
