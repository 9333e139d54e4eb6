"""Pairs of pictures with the three outcomes of an SC-experiment, made without playing one (paper, section IV-A, "Training").

What makes the pairs honest: light, exposure, noise and the camera differ a little between the two pictures of a pair; robots come back almost, not
only exactly or not at all; objects move by centimetres or metres; the robot's arm is in sight, and sometimes it is all that moved.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..worlds.apartment.scene import IDENTITIES
from .household import TRIES, Household, View, displaced
from .outcome import SEEN, Outcome, outcome_of
from .sensor import JITTER, jittered, photographed, some_light

PAIRS_PER_SCATTER = 60
"""Pairs with the same objects in the same places; chosen: scattering takes as long as some five of them."""
FALL = 30
"""Substeps (an eighth of a second) in which a displaced object comes to rest."""


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

    def __init__(self, household: Household):
        self.household, self.simulation, self.rng = household, household.simulation, household.rng
        self.camera = household.cameras[0]
        self._since = PAIRS_PER_SCATTER

    def pair(self, outcome: Outcome) -> Pair:
        """A pair with this outcome; situations in which it does not come about are drawn anew."""
        make = {"identical": self._identical, "different": self._different, "moved": self._moved}[outcome]
        while True:
            if self._since >= PAIRS_PER_SCATTER:
                self.household.scatter()
                self._since = 0
            self.household.begin()
            self._since += 1
            made = make()
            if made is not None and made.outcome == outcome:
                return made

    # ---- pictures ----------------------------------------------------------------------------------------------------------

    def _look(self, jitter: float = 0.0) -> View:
        """What is seen; `jitter`, degrees, is the scale of how the camera is turned."""
        eye = self.simulation.eye_pose()
        return self.household.look(jittered(eye, jitter, self.rng) if jitter else eye, some_light(self.rng))

    def _made(self, first: View, second: View, moved: np.ndarray, kind: str) -> Pair:
        (picture, *_), (other, *_) = first.pictures, second.pictures
        outcome, masks = outcome_of(picture, other, first.eye, second.eye, moved, self.camera)
        if self.rng.uniform() < 0.5:
            picture, other, masks = other, picture, masks[::-1]
        return Pair(np.stack([photographed(picture.rgb, self.rng), photographed(other.rgb, self.rng)]), np.ascontiguousarray(masks), outcome, kind)

    def _back(self) -> float:
        """The robot comes back, more or less: its arm almost where it was in some cases; returns how its camera is to be jittered."""
        simulation, rng = self.simulation, self.rng
        if rng.uniform() < 0.25:
            base, joints = simulation.base(), simulation.joints()
            bent = joints + rng.normal(0, 0.01, len(joints)) * (rng.uniform(size=len(joints)) < 0.3)
            simulation.put_robot(base, np.clip(bent, *simulation.robot.limits.T))
        return 0.0 if rng.uniform() < 0.3 else JITTER

    # ---- outcomes ----------------------------------------------------------------------------------------------------------

    def _identical(self) -> Pair:
        first, jitter = self._look(), self._back()
        return self._made(first, self._look(jitter), np.array([], int), "jitter" if jitter else "still")

    def _different(self) -> Pair | None:
        first, simulation, rng = self._look(), self.simulation, self.rng
        kind = str(rng.choice(["turned", "almost", "elsewhere", "arm"], p=[0.25, 0.25, 0.1, 0.4]))
        if kind == "elsewhere":
            self.household.begin()
            return self._made(first, self._look(), np.array([], int), kind)
        base, joints = simulation.base(), simulation.joints()
        for _ in range(TRIES):
            there, bent = self._elsewhere(kind, base.copy(), joints.copy())
            simulation.put_robot(there, np.clip(bent, *simulation.robot.limits.T))
            if not simulation.penetrates():
                return self._made(first, self._look(), np.array([], int), kind)
        return None

    def _elsewhere(self, kind: str, base: np.ndarray, joints: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Another place of the base or another bend of the arm: turned by 45 degrees and more, by less, or the arm alone."""
        rng = self.rng
        if kind == "turned":
            base[2] += rng.choice([-1, 1]) * (math.pi / 2 if rng.uniform() < 0.5 else rng.uniform(math.pi / 4, math.pi))
        elif kind == "almost":
            base[2] += rng.choice([-1, 1]) * math.radians(math.exp(rng.uniform(math.log(0.5), math.log(45.0))))
            base[:2] += rng.normal(0, 0.03, 2) * rng.integers(2)
        else:
            bends = rng.choice([-1, 1], len(joints)) * np.exp(rng.uniform(math.log(0.01), math.log(1.0), len(joints)))
            one = np.arange(len(joints)) == rng.integers(len(joints))
            joints += bends * (one if rng.uniform() < 0.7 else rng.uniform(size=len(joints)) < 0.4)
        return base, joints

    def _moved(self) -> Pair | None:
        simulation, rng = self.simulation, self.rng
        first = self._look()
        identity, before = first.pictures[0].identity, simulation.object_poses()
        counts = np.bincount(np.where(identity < IDENTITIES["fixture"], identity, 0).ravel(), minlength=len(before) + 1)[1:]
        seen = np.nonzero(counts >= SEEN)[0]
        if not len(seen):
            return None
        chosen = rng.choice(seen, size=min(len(seen), int(rng.geometric(0.6))), replace=False)
        if rng.uniform() < 0.15:  # something comes into sight
            chosen[0] = rng.integers(len(before))
        moved = [int(i) for i in chosen if self._displace(int(i), before[i])]
        if not moved:
            return None
        simulation.wait(FALL)
        others = np.setdiff1d(np.arange(len(before)), np.union1d(moved, displaced(before, simulation.object_poses())))
        for i in others:
            simulation.put_object(int(i), before[i])  # to the last bit
        really = displaced(before, simulation.object_poses())
        return self._made(first, self._look(self._back()), really, "moved")

    def _displace(self, i: int, pose: np.ndarray) -> bool:
        """By 3 to 60 cm in most cases, as arms and bases push; else to anywhere in front of the robot."""
        rng, base = self.rng, self.simulation.base()
        for _ in range(TRIES):
            if rng.uniform() < 0.7:
                distance, angle = math.exp(rng.uniform(math.log(0.03), math.log(0.6))), rng.uniform(-math.pi, math.pi)
                x, y = pose[0] + distance * math.cos(angle), pose[1] + distance * math.sin(angle)
            else:
                distance, angle = rng.uniform(0.5, 3.0), base[2] + rng.uniform(-0.6, 0.6)
                x, y = base[0] + distance * math.cos(angle), base[1] + distance * math.sin(angle)
            if self.household.stand(i, x, y, pose[2] + 0.3):
                return True
        self.simulation.put_object(i, pose)
        return False
