"""A first description of a robot, from its URDF alone: `sencom robot init`."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ....seeding import generator
from .. import frames as fr
from ..files import portable_name
from ..physics.simulation import Simulation
from ..robots.loading import parse_robot
from ..robots.robot import Robot
from ..robots.shape_sizes import link_frames, link_points, measure_wheel_radius
from ..robots.urdf import RobotError, Urdf
from ..robots.urdf_reader import read_urdf
from ..scenes.empty import empty_floor
from .guesses import (
    ORDER,
    JointGuess,
    allowed_start,
    guess_camera,
    guess_joint,
    guess_start,
    guess_wheel,
    make_name,
)
from .wheels import Drive, find_drive

POSES = 200
"""Random poses in which pairs of links are tried. Chosen: takes seconds."""
ALWAYS = 0.95
"""Share of the poses from which on a pair of links counts as always touching. Chosen."""
CENTRES = 40
"""Other middles of the start ranges that are tried if most starts touch something. Chosen."""
ENOUGH_FREE = 0.5
"""Share of the starts that must touch nothing. Chosen."""

LEGS = {"hip", "thigh", "calf", "ankle"}
"""Groups of joints of a robot that stands on legs."""
FLOOR = "(floor)"
"""Stands for the floor among links; no link has this name."""


@dataclass
class Draft:
    """A description and what was guessed about it.

    Attributes
    ----------
    settings : dict
        What the YAML file holds.
    comments : dict
        Key, or name of a degree of freedom -> why it is so.
    notes : list of str
        What people should know before they use it.
    """

    settings: dict[str, Any]
    comments: dict[str, str] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)


def draft_robot(path: Path, out: Path, name: str | None = None) -> Draft:
    """Guess the description of a robot.

    Parameters
    ----------
    path : Path
        A URDF or xacro file.
    out : Path
        The file that the description will be written to: it names the URDF relative to it.
    name : str, optional
        By default that of the URDF.

    Raises
    ------
    RobotError
        The URDF or one of its meshes cannot be read, or the robot has no joint that moves.
    """
    urdf = read_urdf(path)
    drive = find_drive(urdf)
    guesses = _guess_joints(urdf, drive)
    if not guesses:
        raise RobotError(
            f"{path}: no joint of it can move, so it has no degrees of freedom; name the URDF of a "
            "robot"
        )
    camera, why = guess_camera(urdf, drive.heading if drive is not None else 0.0)
    settings: dict[str, Any] = {
        "name": make_name(name or urdf.name, set()),
        "urdf": portable_name(path, out.resolve().parent),
        "dofs": [_describe_dof(guess) for guess in guesses],
        "camera": camera,
    }
    draft = Draft(settings, {"camera": why, **{g.name: _describe_joint(g) for g in guesses}})
    draft.notes += list(urdf.notes)
    if drive is not None:
        _add_drive(draft, urdf, drive)
    groups = {guess.group for guess in guesses}
    settings["hierarchy"] = [group for group in ORDER if group in groups]
    if len(settings["hierarchy"]) < 2:
        del settings["hierarchy"]
    settings["start"] = {g.joint.name: list(g.start) for g in guesses if g.start is not None}
    if not settings["start"]:
        del settings["start"]
    folder, where = out.resolve().parent, str(out)
    on_legs = bool(groups & LEGS)
    if drive is None and not on_legs:
        _stand_on_base(draft, folder, where)
    free, on_floor = _Trial(draft, guesses, folder, where, lifted=on_legs).improve()
    if drive is None and (on_legs or (free < ENOUGH_FREE and on_floor > 0)):
        _hang_above_floor(draft, folder, where, on_legs)
        if not on_legs:
            free, _ = _Trial(draft, guesses, folder, where, lifted=True).improve()
    if free < 0.1:
        draft.notes.append(f"only {free:.0%} of the start positions touch nothing; set start")
    return draft


def _guess_joints(urdf: Urdf, drive: Drive | None) -> list[JointGuess]:
    taken: set[str] = set()
    guesses = []
    wheels = [drive.right, drive.left] if drive is not None else []
    idle = drive.idle if drive is not None else ()
    for name in wheels:
        joint = urdf.joints[name]
        guesses.append(guess_wheel(joint, measure_wheel_radius(urdf, wheels[0]), taken))
        taken.add(guesses[-1].name)
    for joint in urdf.joints.values():
        moves = joint.kind != "fixed" and joint.lower < joint.upper and joint.mimic is None
        if moves and joint.name not in wheels and joint.name not in idle:
            guesses.append(guess_joint(urdf, joint, taken))
            taken.add(guesses[-1].name)
    return guesses


def _describe_dof(guess: JointGuess) -> dict[str, Any]:
    return {
        "name": guess.name,
        "joints": [guess.joint.name],
        "unit": guess.unit,
        "velocity": guess.velocity,
        "group": guess.group,
    }


def _describe_joint(guess: JointGuess) -> str:
    joint = guess.joint
    limits = "no stops"
    if np.isfinite(joint.upper - joint.lower):
        limits = f"{joint.lower:g} to {joint.upper:g} {guess.unit}"
    fastest = ""
    if np.isfinite(joint.velocity):
        fastest = f", at most {joint.velocity:g} {guess.unit}/s"
    return f"{joint.kind}, {limits}{fastest}"


def _add_drive(draft: Draft, urdf: Urdf, drive: Drive) -> None:
    settings: dict[str, Any] = {"right_wheel": drive.right, "left_wheel": drive.left}
    if drive.axle is not None:
        settings["axle"] = drive.axle
    draft.settings["drive"] = settings
    radius = measure_wheel_radius(urdf, drive.right)
    draft.comments["drive"] = f"found: round, level, on the floor; radius {radius:.3g} m"
    if drive.idle:
        draft.notes.append(f"no degree of freedom moves the wheels {', '.join(drive.idle)}")


class _Trial:
    """Tries a draft in free space, and improves its pairs of links and its start ranges."""

    def __init__(
        self, draft: Draft, guesses: list[JointGuess], folder: Path, where: str, lifted: bool
    ):
        self._draft, self._folder, self._where = draft, folder, where
        self._guesses = [guess for guess in guesses if guess.start is not None]
        # High above the floor, only the robot itself is in its way.
        height = {"height": 30.0} if lifted else {}
        self._robot = parse_robot({**draft.settings, **height}, folder, where)
        self._simulation = Simulation(empty_floor("free-space"), self._robot)
        self._rng = generator(0, "draft")

    def improve(self) -> tuple[float, float]:
        """Add passing pairs, and better starts.

        Returns the share of the starts that touch nothing, and of those that touch the floor.
        """
        settings, comments = self._draft.settings, self._draft.comments
        passing, on_floor = self._find_passing()
        if passing:
            settings["passing"] = [list(pair) for pair in passing]
        comments.update({f"{a} {b}": f"touch in {share:.0%}" for (a, b), share in passing.items()})
        free = self._share_free(set(passing), {})
        if free < ENOUGH_FREE:
            free = self._move_starts(set(passing), free)
        self._simulation.close()
        return free, on_floor

    def _find_passing(self) -> tuple[dict[tuple[str, str], float], float]:
        """Pairs of links that touch in nearly all poses, with shares; share of floor contacts."""
        start: Counter[tuple[str, str]] = Counter()
        anywhere: Counter[tuple[str, str]] = Counter()
        for _ in range(POSES):
            start.update(self._touching({}))
            anywhere.update(self._touching(self._anywhere()))
        shares = {pair: max(start[pair], anywhere[pair]) / POSES for pair in start | anywhere}
        low = {pair: min(start[pair], anywhere[pair]) / POSES for pair in shares}
        # Nearly always from the starts, and often elsewhere: the hulls overlap, not the motion.
        passing = {
            pair: share for pair, share in sorted(shares.items())
            if share >= ALWAYS and low[pair] >= 1 - ALWAYS
        }  # fmt: skip
        on_floor = sum(count for pair, count in start.items() if FLOOR in pair) / POSES
        return {pair: share for pair, share in passing.items() if FLOOR not in pair}, on_floor

    def _anywhere(self) -> dict[str, float]:
        """Random positions within the limits."""
        positions = {}
        for guess in self._guesses:
            low, high = guess.joint.lower, guess.joint.upper
            if not np.isfinite(high - low):
                low, high = -np.pi, np.pi
            positions[guess.joint.name] = float(self._rng.uniform(low, high))
        return positions

    def _touching(self, positions: Mapping[str, float]) -> set[tuple[str, str]]:
        """Pairs of links, or a link and the floor, that touch at `positions` or a random start."""
        joints = self._robot.draw_joints(self._rng)
        for i, joint in enumerate(self._robot.joints):
            joints[i] = positions.get(joint.name, joints[i])
        self._simulation.fits(np.zeros(3), self._robot.clip_joints(joints))
        pairs = self._simulation.collisions.penetrating_pairs()
        return {(a, b if kind == "link" else FLOOR) for a, kind, b in pairs}

    def _share_free(self, passing: set, centre: Mapping[str, float], draws: int = 40) -> float:
        free = 0
        for _ in range(draws):
            positions = {
                guess.joint.name: float(self._rng.uniform(
                    *guess_start(guess.joint, guess.velocity, centre[guess.joint.name])
                ))
                for guess in self._guesses if guess.joint.name in centre
            }  # fmt: skip
            free += not self._touching(positions) - passing
        return free / draws

    def _move_starts(self, passing: set, best: float) -> float:
        """Try other start ranges, and keep those from which most starts touch nothing."""
        chosen: Mapping[str, float] | None = None
        for _ in range(CENTRES):
            centre = {
                guess.joint.name: float(
                    self._rng.uniform(*allowed_start(guess.joint, guess.velocity))
                )
                for guess in self._guesses
            }
            if self._touching(centre) - passing:
                continue
            free = self._share_free(passing, centre, 20)
            if free > best:
                chosen, best = centre, free
            if best >= 0.9:
                break
        if chosen is not None:
            for guess in self._guesses:
                name = guess.joint.name
                self._draft.settings["start"][name] = list(
                    guess_start(guess.joint, guess.velocity, chosen[name])
                )
            self._draft.comments["start"] = "found by trying: the robot touches itself near zero"
        return best


def _stand_on_base(draft: Draft, folder: Path, where: str) -> None:
    """Let the lowest point of what does not move stand on the floor."""
    robot = parse_robot(draft.settings, folder, where)
    base, _ = _lowest_points(robot, robot.start_ranges.mean(1))
    if base is not None and abs(base) > 0.005:
        draft.settings["height"] = round(-base + 0.001, 3)
        draft.comments["height"] = "metres from the floor to the root link, by its lowest shape"


def _hang_above_floor(draft: Draft, folder: Path, where: str, on_legs: bool) -> None:
    """Hold a robot so high that no motion from a start reaches the floor."""
    robot = parse_robot(draft.settings, folder, where)
    rng = generator(0, "height")
    lowest: list[float] = []
    for _ in range(40):
        points = _lowest_points(robot, robot.clip_joints(_excursion(robot, rng)))
        lowest += [point for point in points if point is not None]
    draft.settings["height"] = round(-min(lowest, default=0.0) + 0.02, 3)
    draft.comments["height"] = "metres from the floor to the root link: hangs above the floor"
    what = "stands on legs: its body is held still" if on_legs else "reaches below its base"
    draft.notes.append(
        f"{what}, so it hangs above the floor, and the SCP is that of motions in the air"
    )


def _excursion(robot: Robot, rng: np.random.Generator) -> np.ndarray:
    """Joint positions that 50 random actions may reach from a start."""
    velocity = np.array(
        [robot.description.dofs[robot.dof_of_joint[joint.name]].velocity for joint in robot.joints]
    )
    return robot.draw_joints(rng) + rng.uniform(-1, 1, len(robot.joints)) * velocity


def _lowest_points(robot: Robot, joints: np.ndarray) -> tuple[float | None, float | None]:
    """Lowest z, in the root link, of links that no joint moves, and of the others."""
    positions = {joint.name: float(q) for joint, q in zip(robot.joints, joints, strict=True)}
    frames = link_frames(robot.urdf, positions)
    moved_links: set[str] = set()
    stack = [joint.child for joint in robot.joints]
    while stack:
        link = stack.pop()
        moved_links.add(link)
        stack += [joint.child for joint in robot.urdf.joints_below(link)]
    lowest: dict[bool, float] = {}
    for name, body in robot.urdf.links.items():
        points = link_points(body)
        if len(points):
            z, key = float(fr.apply(frames[name], points)[:, 2].min()), name in moved_links
            lowest[key] = min(z, lowest.get(key, z))
    return lowest.get(False), lowest.get(True)
