"""Guesses about joints from their names and places: group, velocity, start, camera."""

from __future__ import annotations

import math
import re
from typing import NamedTuple

import numpy as np

from .. import frames as fr
from ..robots.shape_sizes import link_frames, link_points, measure_extent
from ..robots.urdf import Joint, Urdf

GROUPS = (
    ("wheel", r"wheel|caster"),
    ("hand", r"finger|gripper|thumb|hand|jaw|knuckle|palm|claw|pinky|(^|_)(ff|mf|rf|lf|th)j\d"),
    ("hip", r"hip|haa|abduct"),
    ("thigh", r"thigh|hfe|upper_?leg|leg_?upper|knee_?upper"),
    ("calf", r"calf|knee|kfe|lower_?leg|shin"),
    ("ankle", r"ankle|foot|toe"),
    ("shoulder", r"shoulder|upper_?arm_?pan|clavicle"),
    ("elbow", r"elbow|upper_?arm|arm_?extend"),
    ("wrist", r"wrist|forearm|lower_?arm"),
    ("head", r"head|neck|camera|(^|_)(pan|tilt)(_|$)|eye"),
    ("torso", r"torso|lift|column|waist|spine|chest|body_yaw"),
)
"""Groups and what the names of their joints contain, in the order in which they are tried."""
ORDER = ("wheel", "torso", "shoulder", "elbow", "wrist")
"""Groups from the lowest expected SCP to the highest (paper, section III-B)."""
MAX_SPEED = {"rad": 1.0, "m": 0.1}
"""rad/s and m/s; chosen: 50 random actions then move a joint by about 0.4 rad or 0.04 m."""
MAX_DRIVE_SPEED = 0.5
"""m/s of wheels; chosen: as a robot among people."""
LIMIT_SHARE = 0.8
"""Of the URDF's limit of the velocity; so iGibson commands Fetch (config/robots/fetch.yaml)."""
CAMERAS = r"camera|kinect|realsense|xtion|zed|(^|_)eyes?($|_)|lens|rgb"


class JointGuess(NamedTuple):
    """What a degree of freedom of one joint is described by.

    `start` is None for a wheel; numbers in rad or m, and per second.
    """

    joint: Joint
    name: str
    unit: str
    group: str
    velocity: float
    start: tuple[float, float] | None


def make_name(text: str, taken: set[str]) -> str:
    """A valid and new name of a degree of freedom."""
    name = re.sub(r"[^a-z0-9]+", "-", text.lower()).strip("-")
    name = re.sub(r"-joint(?=-|$)|^joint-(?=[a-z])", "", name)[:36].strip("-") or "joint"
    candidate, number = name, 2
    while candidate in taken:
        candidate, number = f"{name}-{number}", number + 1
    return candidate


def guess_group(urdf: Urdf, joint: Joint) -> str:
    """The kind of a joint, by its name, its link's, or its place in the chain."""
    for text in (joint.name, joint.child):
        for group, pattern in GROUPS:
            if group != "wheel" and re.search(pattern, text.lower()):
                return group
    above = urdf.joint_above(joint.parent)
    while above is not None and above.kind == "fixed":
        above = urdf.joint_above(above.parent)
    below_in_leg = {"hip": "thigh", "thigh": "calf", "calf": "ankle"}
    next_group = below_in_leg.get(guess_group(urdf, above)) if above is not None else None
    if next_group is not None:
        return next_group
    if joint.kind == "prismatic":
        return "slide"
    chain, depth = _movable_chain(urdf, joint)
    third = 3 * depth / max(chain, 1)
    return ("shoulder", "elbow", "wrist")[min(int(third), 2)]


def _movable_chain(urdf: Urdf, joint: Joint) -> tuple[int, int]:
    """Movable joints on the longest way through a joint, and how many of them come before it."""
    before, above = 0, urdf.joint_above(joint.parent)
    while above is not None:
        before += above.kind != "fixed"
        above = urdf.joint_above(above.parent)
    after, level = 0, [(joint.child, 0)]
    while level:
        link, count = level.pop()
        after = max(after, count)
        for below in urdf.joints_below(link):
            moves = below.kind != "fixed" and below.mimic is None
            level.append((below.child, count + moves))
    return before + 1 + after, before


def guess_joint(urdf: Urdf, joint: Joint, taken: set[str]) -> JointGuess:
    """What describes a joint other than a wheel."""
    unit = "m" if joint.kind == "prismatic" else "rad"
    span = joint.upper - joint.lower
    limit = LIMIT_SHARE * joint.velocity if np.isfinite(joint.velocity) else np.inf
    # Half the range: 50 random actions from its middle then seldom reach a stop.
    velocity = _round(min(MAX_SPEED[unit], limit, span / 2))
    name = make_name(joint.name, taken)
    start = guess_start(joint, velocity)
    return JointGuess(joint, name, unit, guess_group(urdf, joint), velocity, start)


def guess_wheel(joint: Joint, radius: float, taken: set[str]) -> JointGuess:
    """What describes a wheel of the drive."""
    limit = LIMIT_SHARE * joint.velocity if np.isfinite(joint.velocity) else np.inf
    velocity = _round(min(MAX_DRIVE_SPEED / radius, limit))
    return JointGuess(joint, make_name(joint.name, taken), "rad", "wheel", velocity, None)


def guess_start(joint: Joint, velocity: float, centre: float = 0.0) -> tuple[float, float]:
    """A range around `centre` that keeps away from the stops, as far as there is room."""
    if not np.isfinite(joint.upper - joint.lower):
        return -0.5 + centre, 0.5 + centre
    low, high = allowed_start(joint, velocity)
    half = min(0.1 * (joint.upper - joint.lower), 0.6)
    middle = min(max(centre, low + min(half, (high - low) / 2)), high - min(half, (high - low) / 2))
    return _inside(max(low, middle - half), joint), _inside(min(high, middle + half), joint)


def allowed_start(joint: Joint, velocity: float) -> tuple[float, float]:
    """The positions from which 50 random actions seldom reach a stop."""
    if not np.isfinite(joint.upper - joint.lower):
        return -3.1, 3.1
    span = joint.upper - joint.lower
    margin = min(max(velocity, 0.15 * span), 0.45 * span)
    return joint.lower + margin, joint.upper - margin


def guess_camera(urdf: Urdf, heading: float = 0.0) -> tuple[dict, str]:
    """The key camera of a description, and why.

    `heading` is the direction in which the robot drives, in the root link, rad.
    """
    named = [name for name in urdf.links if re.search(CAMERAS, name.lower())]
    named.sort(key=lambda name: ("optical" in name, not re.search("rgb|colou?r", name), len(name)))
    if named and "optical" in named[0]:  # z forward, x right, y down
        turned = np.eye(4)
        turned[:3, :3] = np.array([[0, -1, 0], [0, 0, -1], [1, 0, 0]])
        rotation = [_round(angle, 5) for angle in fr.to_rpy(turned)]
        camera = {"link": named[0], "position": [0.0, 0.0, 0.01], "rotation": rotation}
        return camera, "guessed by its name"
    heads = [name for name in urdf.links if re.search("head", name.lower())]
    for links, why in ((named[:1], "guessed by its name"), (heads[-1:], "guessed: a head")):
        for link in links:
            return _look_ahead(urdf, link, heading), why
    extent = measure_extent(urdf)
    low, high = (np.zeros(3), np.ones(3)) if extent is None else extent
    size = max(float((high - low).max()), 0.2)
    behind = 0.4 * size + float(np.abs(np.stack([low, high])[:, :2]).max())
    x, y = -behind * math.cos(heading), -behind * math.sin(heading)
    return {
        "link": urdf.root,
        "position": [_round(x), _round(y), _round(float(high[2]) * 0.6 + 0.5 * size)],
        "rotation": [0.0, 0.6, _round(heading)],
    }, "chosen: above and behind, looking down; no link is named like a camera"


def _look_ahead(urdf: Urdf, link: str, heading: float) -> dict:
    """A camera at the front of a link and of what is fixed to it, which looks straight ahead."""
    frames = link_frames(urdf)
    ahead = fr.on_floor(0.0, 0.0, heading)[:3, :3]
    names = [link, *_fixed_to(urdf, link)]
    points = [fr.apply(frames[name], link_points(urdf.links[name])) for name in names]
    everything = np.concatenate([frames[link][None, :3, 3], *points]) @ ahead
    place = np.array([everything[:, 0].max() + 0.01, *(frames[link][:3, 3] @ ahead)[1:]])
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = ahead, ahead @ place
    in_link = np.linalg.inv(frames[link]) @ pose
    rotation = [_round(angle, 5) + 0.0 for angle in fr.to_rpy(in_link)]
    camera: dict = {"link": link, "position": [_round(value) for value in in_link[:3, 3]]}
    return camera | ({"rotation": rotation} if np.abs(rotation).max() > 1e-3 else {})


def _fixed_to(urdf: Urdf, link: str) -> list[str]:
    """Links that do not move relative to another, on both sides of it."""
    names, stack = [], [link]
    while stack:
        below = urdf.joints_below(stack.pop())
        stack += [joint.child for joint in below if joint.kind == "fixed"]
        names += [joint.child for joint in below if joint.kind == "fixed"]
    above = urdf.joint_above(link)
    if above is not None and above.kind == "fixed" and above.parent != urdf.root:
        names += [above.parent]
    return names


def _round(value: float, digits: int = 4) -> float:
    rounded = float(f"{value:.{digits}g}")
    return rounded if abs(rounded) >= 1e-4 else 0.0


def _inside(value: float, joint: Joint) -> float:
    """Round a position, without leaving the limits."""
    return float(min(max(round(value, 4), joint.lower), joint.upper))
