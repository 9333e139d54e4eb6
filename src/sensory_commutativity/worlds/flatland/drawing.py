"""Drawing a Flatland room from above, and what the eye sees."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle, Polygon, Wedge

from .agent import N_LINKS
from .control import HEAD
from .room import FIXED, MOVABLE, MOVING, WALL_COLOURS
from .world import FlatlandWorld

FLOOR, SKIN, EDGE = "#f7f5ef", "#d9c9b0", "#333333"
_ARM_FILLS = ("#ffffff", "#c8c8c8", "#ffffff", "#c8c8c8")
_THING_EDGES = {
    FIXED: dict(linewidth=2.4, linestyle="-"),
    MOVABLE: dict(linewidth=0.8, linestyle="-"),
    MOVING: dict(linewidth=1.4, linestyle=":"),
}


def draw_room(axes: Axes, world: FlatlandWorld, sight: bool = True) -> None:
    """Draw the room from above as it is now: walls, things, the agent and, if asked, its field of view.

    Fixed things have a thick outline, movable ones a thin one, moving ones a dotted one and the path they follow; walls that are not solid
    are dashed.
    """
    poses, situation, room = world.poses(), world.situation, world.room
    axes.set_aspect("equal")
    axes.set_axis_off()
    corners = [(0, 0), (room.width, 0), (room.width, room.height), (0, room.height)]
    axes.add_patch(Polygon(corners, facecolor=FLOOR, edgecolor="none", zorder=0))
    for k in range(4):
        (x1, y1), (x2, y2) = corners[k], corners[(k + 1) % 4]
        solid = (
            dict(linewidth=4, solid_capstyle="round")
            if room.walls
            else dict(linewidth=1.5, linestyle="--")
        )
        axes.plot([x1, x2], [y1, y2], color=WALL_COLOURS[k] / 255, zorder=1, **solid)
    axes.set_xlim(-12, room.width + 12)
    axes.set_ylim(-12, room.height + 12)
    for mark in room.marks:
        axes.add_patch(
            Circle(
                (mark.x, mark.y),
                mark.radius,
                facecolor=np.array(mark.colour) / 255,
                edgecolor="none",
                alpha=0.7,
                zorder=0.7,
            )
        )
    if sight:
        _draw_sight(axes, world, poses)
    for i in range(situation.n_things):
        _draw_thing(axes, world, i, poses[N_LINKS + i])
    _draw_agent(axes, world, poses)


def _draw_sight(axes: Axes, world: FlatlandWorld, poses: np.ndarray) -> None:
    agent, room = world.agent, world.room
    middle = math.degrees(poses[0, 2] + world.inner[HEAD])
    half = math.degrees(agent.field_of_view) / 2
    wedge = Wedge(
        poses[0, :2],
        agent.view_range,
        middle - half,
        middle + half,
        facecolor="#ffd94d",
        alpha=0.22,
        edgecolor="none",
        zorder=0.5,
    )
    axes.add_patch(wedge)
    wedge.set_clip_path(
        Polygon(
            [(0, 0), (room.width, 0), (room.width, room.height), (0, room.height)],
            transform=axes.transData,
        )
    )


def _draw_thing(axes: Axes, world: FlatlandWorld, i: int, pose: np.ndarray) -> None:
    situation = world.situation
    kind, corners, radius = situation.kind[i], situation.vertices[i], situation.radius[i]
    look = dict(facecolor=situation.colour[i] / 255, edgecolor=EDGE, zorder=3, **_THING_EDGES[kind])
    if kind == MOVING:
        axes.add_patch(
            Polygon(
                situation.path[i, : situation.corners[i]],
                fill=False,
                edgecolor=EDGE,
                linewidth=0.7,
                linestyle=":",
                zorder=2,
            )
        )
    if corners == 0:
        axes.add_patch(Circle(pose[:2], radius, **look))
    else:
        angles = pose[2] + 2 * math.pi * np.arange(corners) / corners
        axes.add_patch(
            Polygon(pose[:2] + radius * np.stack([np.cos(angles), np.sin(angles)], 1), **look)
        )


def _draw_agent(axes: Axes, world: FlatlandWorld, poses: np.ndarray) -> None:
    agent = world.agent
    x, y, heading = poses[0]
    half = np.array([agent.arm_length, agent.arm_width]) / 2
    box = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * half
    for i in range(1, N_LINKS):
        cos, sin = math.cos(poses[i, 2]), math.sin(poses[i, 2])
        turned = box @ np.array([[cos, sin], [-sin, cos]]) + poses[i, :2]
        axes.add_patch(
            Polygon(turned, facecolor=_ARM_FILLS[i - 1], edgecolor=EDGE, linewidth=0.8, zorder=4)
        )
    axes.add_patch(
        Circle((x, y), agent.base_radius, facecolor=SKIN, edgecolor=EDGE, linewidth=1.0, zorder=5)
    )
    nose = np.array([math.cos(heading), math.sin(heading)]) * agent.base_radius
    axes.plot(
        [x + 0.6 * nose[0], x + nose[0]],
        [y + 0.6 * nose[1], y + nose[1]],
        color=EDGE,
        linewidth=1.4,
        zorder=6,
    )
    gaze = heading + world.inner[HEAD]
    axes.add_patch(
        Circle(
            (x, y),
            agent.base_radius * 0.4,
            facecolor="white",
            edgecolor=EDGE,
            linewidth=0.8,
            zorder=6,
        )
    )
    pupil = (
        x + 0.2 * agent.base_radius * math.cos(gaze),
        y + 0.2 * agent.base_radius * math.sin(gaze),
    )
    axes.add_patch(Circle(pupil, agent.base_radius * 0.15, facecolor="black", zorder=7))


def draw_view(axes: Axes, view: np.ndarray) -> None:
    """Draw what the eye sees, uint8 (pixels, 3), as a strip; its left is the agent's left."""
    axes.imshow(view[None, ::-1], aspect="auto", interpolation="nearest")
    axes.set_xticks([])
    axes.set_yticks([])
    axes.spines[:].set_visible(True)
