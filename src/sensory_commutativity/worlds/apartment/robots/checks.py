"""Checks that a robot's description and its URDF agree.

Every message names the key of the description and how to correct it.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from .robot import Robot
from .shape_sizes import measure_extent, measure_wheel_radius
from .urdf import Joint, RobotError
from .urdf_elements import MAX_LENGTH
from .visuals import load_shape_mesh

MAX_DIFFERENCE = 0.1
"""Relative difference between a size in the description and in the URDF that is taken as meant;
chosen: a worn tyre differs by less."""
MIN_EXTENT = 0.02
"""Metres: a robot that is smaller as a whole is taken for a mistake in units; chosen."""


def find_problems(robot: Robot) -> Iterator[str]:
    """Yield every disagreement between the description and the URDF of a robot."""
    driven_by = {name: dof.name for dof in robot.description.dofs for name in dof.joints}
    yield from _check_dofs(robot)
    yield from _check_ratios(robot)
    yield from _check_drive(robot, driven_by)
    yield from _check_hierarchy(robot)
    yield from _check_links(robot)
    yield from _check_fixed(robot, driven_by)
    yield from _check_start(robot)


def _check_dofs(robot: Robot) -> Iterator[str]:
    file, joints, dofs = robot.urdf.path.name, robot.urdf.joints, robot.description.dofs
    driven_by: dict[str, str] = {}
    for dof in dofs:
        if [each.name for each in dofs].count(dof.name) > 1:
            yield f"dofs: two are called {dof.name!r}; rename one"
        for name in dof.joints:
            where = f"dofs: {dof.name!r} names the joint {name!r}"
            if name not in joints:
                yield f"{where}, which {file} does not contain; choose one of {_movable(joints)}"
                continue
            if name in driven_by:
                yield (
                    f"dofs: the joint {name!r} is moved by {driven_by[name]!r} "
                    f"and by {dof.name!r}; remove it from one"
                )
            driven_by[name] = dof.name
            kind = joints[name].kind
            if kind == "fixed":
                yield f"{where}, which cannot move; choose one of {_movable(joints)}"
            elif joints[name].lower == joints[name].upper == 0:
                yield (
                    f"{where}, which cannot move: its limits in {file} are both 0; write lower and "
                    "upper, or make the joint continuous if it has no stops"
                )
            elif joints[name].lower == joints[name].upper:
                yield (
                    f"{where}, which cannot move: its limits in {file} are both "
                    f"{joints[name].lower:g}; choose one of {_movable(joints)}"
                )
            unit = "m" if kind == "prismatic" else "rad"
            if dof.unit != unit:
                yield (
                    f"dofs: {dof.name!r} has the unit {dof.unit}, "
                    f"but its joint {name!r} is {kind}; write {unit}"
                )


def _check_drive(robot: Robot, driven_by: dict[str, str]) -> Iterator[str]:
    for key, name in zip(("right_wheel", "left_wheel"), robot.wheels, strict=False):
        if name not in driven_by:
            yield (
                f"drive.{key}: the joint {name!r} belongs to no degree of freedom; "
                "name the joint of a wheel that is listed under dofs"
            )
    if len(set(robot.wheels)) == 1:
        yield f"drive: both wheels are the joint {robot.wheels[0]!r}; name two"
    elif all(name in robot.urdf.joints for name in robot.wheels):
        yield from _check_axle(robot)
    for dof in robot.description.dofs:
        if set(dof.joints) & set(robot.wheels) and len(dof.joints) > 1:
            yield (
                f"dofs: {dof.name!r} moves a wheel and another joint; "
                "give each wheel its own degree of freedom"
            )


def _check_axle(robot: Robot) -> Iterator[str]:
    """Compare the drive with where the URDF puts the wheels."""
    if not robot.wheels or robot.description.drive is None:
        return
    file, (right, left) = robot.urdf.path.name, robot.wheel_positions
    measured, given = robot.measured_track, robot.description.drive.track
    if measured < 1e-3:
        yield (
            f"drive: {file} puts both wheels at the same place, so they cannot turn the robot; "
            "name a wheel on each side"
        )
    elif right[1] > left[1] + 1e-3 and abs(right[0] - left[0]) < measured / 2:
        yield (
            f"drive: {file} puts the right wheel {robot.wheels[0]!r} at y = {right[1]:g} and the "
            f"left wheel {robot.wheels[1]!r} at y = {left[1]:g}, but left is where y is larger; "
            "exchange them"
        )
    elif given is not None and abs(given - measured) > MAX_DIFFERENCE * measured:
        yield (
            f"drive.track: is {given:g} m, but in {file} the wheels are {measured:g} m apart; "
            "write metres, or leave the key out to take the URDF's"
        )


def _check_ratios(robot: Robot) -> Iterator[str]:
    for dof in robot.description.dofs:
        for name, ratio in dof.ratio.items():
            if name not in dof.joints:
                yield (
                    f"dofs: {dof.name!r} has a ratio of the joint {name!r}, which it does not "
                    f"move; choose one of {', '.join(dof.joints)}"
                )
            elif ratio == 0:
                yield f"dofs: {dof.name!r} has the ratio 0 of {name!r}; give another, or remove it"


def check_shapes(robot: Robot) -> None:
    """Read all meshes, and compare sizes with the description's.

    Raises
    ------
    RobotError
        In one line: the file, the problem and the remedy.
    """
    for link in robot.urdf.links.values():
        for shape in (*link.visuals, *link.collisions):
            if shape.kind == "mesh":
                load_shape_mesh(shape)
    extent = measure_extent(robot.urdf)
    where = f"{robot.urdf.path}:"
    if extent is not None and np.ptp(extent, axis=0).max() < MIN_EXTENT:
        raise RobotError(
            f"{where} the whole robot is {np.ptp(extent, axis=0).max():g} m long; write lengths in "
            "metres, and correct the scale of its meshes"
        )
    if extent is not None and np.ptp(extent, axis=0).max() > MAX_LENGTH:
        raise RobotError(
            f"{where} the whole robot is {np.ptp(extent, axis=0).max():g} m long, more than "
            f"{MAX_LENGTH:g} m; write metres (are these millimetres?)"
        )
    drive = robot.description.drive
    if drive is None or drive.wheel_radius is None:
        return
    try:
        measured = measure_wheel_radius(robot.urdf, drive.right_wheel)
    except RobotError:  # a wheel without a shape
        return
    if abs(drive.wheel_radius - measured) > 2 * MAX_DIFFERENCE * measured:
        raise RobotError(
            f"{robot.description.name}: drive.wheel_radius: is {drive.wheel_radius:g} m, but "
            f"{robot.urdf.path.name} has a wheel of {measured:.3g} m; write metres, or leave the "
            "key out to take the URDF's"
        )


def _check_hierarchy(robot: Robot) -> Iterator[str]:
    groups = sorted({dof.group for dof in robot.description.dofs})
    for group in robot.description.hierarchy:
        if group not in groups:
            yield (
                f"hierarchy: no degree of freedom is in the group {group!r}; "
                f"the groups are {', '.join(groups)}"
            )
        elif robot.description.hierarchy.count(group) > 1:
            yield f"hierarchy: the group {group!r} is listed twice; remove one"


def _check_links(robot: Robot) -> Iterator[str]:
    links = robot.urdf.links
    named = [("camera.link", robot.description.camera.link)]
    named += [("passing", name) for pair in robot.description.passing for name in pair]
    for key, name in named:
        if name not in links:
            yield f"{key}: {robot.urdf.path.name} has no link {name!r}; it has {', '.join(links)}"


def _check_fixed(robot: Robot, driven_by: dict[str, str]) -> Iterator[str]:
    joints = robot.urdf.joints
    for name, position in robot.description.fixed.items():
        if name not in joints or joints[name].kind == "fixed":
            yield (
                f"fixed: {robot.urdf.path.name} has no movable joint {name!r}; "
                f"choose among {_movable(joints)}"
            )
        elif name in driven_by:
            yield (
                f"fixed: the joint {name!r} is moved by {driven_by[name]!r}; "
                "give it a range under start instead"
            )
        elif not joints[name].lower <= position <= joints[name].upper:
            lower, upper = joints[name].lower, joints[name].upper
            yield f"fixed: {name!r} cannot be at {position:g}; it moves from {lower:g} to {upper:g}"


def _check_start(robot: Robot) -> Iterator[str]:
    start, names = robot.description.start, [joint.name for joint in robot.joints]
    for name, (low, high) in start.items():
        if name not in names:
            yield (
                f"start: {name!r} is no joint of a degree of freedom (wheels have no start); "
                f"choose among {', '.join(names)}"
            )
        elif low > high:
            yield f"start: {name!r} has the range {low:g} to {high:g}; write the lower number first"
    ranges = zip(robot.joints, robot.start_ranges, robot.limits, strict=True)
    for joint, (low, high), (lower, upper) in ranges:
        if low < lower - 1e-9 or high > upper + 1e-9:
            default = "" if joint.name in start else " (not listed, so it starts at 0)"
            if joint.name in robot.followers:
                default = f" (it follows {robot.followers[joint.name].joint!r})"
            yield (
                f"start: {joint.name!r} would start from {low:g} to {high:g}{default}, "
                f"beyond its limits {lower:g} to {upper:g}; set a range within them"
            )


def _movable(joints: dict[str, Joint]) -> str:
    return ", ".join(name for name, joint in joints.items() if joint.kind != "fixed")
