"""Checks that a robot's description and its URDF agree.

Every message names the key of the description and how to correct it.
"""

from __future__ import annotations

from collections.abc import Iterator

from .robot import Robot
from .urdf import Joint


def find_problems(robot: Robot) -> Iterator[str]:
    """Yield every disagreement between the description and the URDF of a robot."""
    driven_by = {name: dof.name for dof in robot.description.dofs for name in dof.joints}
    yield from _check_dofs(robot)
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
            if kind == "fixed" or joints[name].lower == joints[name].upper:
                yield f"{where}, which cannot move; choose one of {_movable(joints)}"
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
    for dof in robot.description.dofs:
        if set(dof.joints) & set(robot.wheels) and len(dof.joints) > 1:
            yield (
                f"dofs: {dof.name!r} moves a wheel and another joint; "
                "give each wheel its own degree of freedom"
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
    for joint, (low, high) in zip(robot.joints, robot.start_ranges, strict=True):
        if low < joint.lower or high > joint.upper:
            default = "" if joint.name in start else " (not listed, so it starts at 0)"
            yield (
                f"start: {joint.name!r} would start from {low:g} to {high:g}{default}, "
                f"beyond its limits {joint.lower:g} to {joint.upper:g}; set a range within them"
            )


def _movable(joints: dict[str, Joint]) -> str:
    return ", ".join(name for name, joint in joints.items() if joint.kind != "fixed")
