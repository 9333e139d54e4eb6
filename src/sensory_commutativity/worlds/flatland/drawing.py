"""Drawings of a Flatland room from above, and of the agent's view."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle, Patch, Polygon, Wedge

from .agent import N_LINKS
from .control import HEAD
from .room import FIXED, MOVABLE, MOVING, WALL_COLOURS
from .world import ARM_COLOURS, FlatlandWorld

FLOOR, SKIN, EDGE, SIGHT = "#f7f5ef", "#d9c9b0", "#333333", "#ffd94d"
_KIND_STYLES: dict[int, dict[str, Any]] = {
    FIXED: dict(linewidth=2.4, linestyle="-"),
    MOVABLE: dict(linewidth=0.8, linestyle="-"),
    MOVING: dict(linewidth=1.4, linestyle=":"),
}


def draw_room(axes: Axes, world: FlatlandWorld) -> None:
    """Draw the room from above: walls, zones, objects, the agent and its field of view.

    Fixed objects have a thick outline, movable ones a thin one, moving ones a dotted one and a
    dotted path. Walls that are not solid are dashed.
    """
    poses, room = world.poses(), world.room
    axes.set_aspect("equal")
    axes.set_axis_off()
    corners = [(0, 0), (room.width, 0), (room.width, room.height), (0, room.height)]
    axes.add_patch(Polygon(corners, facecolor=FLOOR, edgecolor="none", zorder=0))
    style: dict[str, Any] = dict(linewidth=1.5, linestyle="--")
    if room.walls:
        style = dict(linewidth=4, solid_capstyle="round")
    for k in range(4):
        (x1, y1), (x2, y2) = corners[k], corners[(k + 1) % 4]
        axes.plot([x1, x2], [y1, y2], color=WALL_COLOURS[k] / 255, zorder=1, **style)
    axes.set_xlim(-12, room.width + 12)
    axes.set_ylim(-12, room.height + 12)
    for zone in room.zones:
        colour = np.array(zone.colour) / 255
        style = dict(facecolor=colour, edgecolor="none", alpha=0.7, zorder=0.7)
        axes.add_patch(Circle((zone.x, zone.y), zone.radius, **style))
    _draw_field_of_view(axes, world, poses[0], corners)
    for i in range(world.situation.n_objects):
        _draw_object(axes, world, i, poses[N_LINKS + i])
    _draw_agent(axes, world, poses)


def _draw_field_of_view(
    axes: Axes, world: FlatlandWorld, base: np.ndarray, corners: list[tuple[float, float]]
) -> None:
    agent = world.agent
    x, y, heading = base
    middle = math.degrees(heading + world.controller_state[HEAD])
    half = math.degrees(agent.field_of_view) / 2
    style: dict[str, Any] = dict(facecolor=SIGHT, alpha=0.22, edgecolor="none", zorder=0.5)
    wedge = Wedge((x, y), agent.view_range, middle - half, middle + half, **style)
    axes.add_patch(wedge)
    wedge.set_clip_path(Polygon(corners, transform=axes.transData))


def _draw_object(axes: Axes, world: FlatlandWorld, i: int, pose: np.ndarray) -> None:
    situation = world.situation
    kind, vertices, radius = situation.kind[i], situation.vertices[i], situation.radius[i]
    x, y, angle = pose
    if kind == MOVING:
        path = situation.path[i, : situation.corners[i]]
        style: dict[str, Any] = dict(linewidth=0.7, linestyle=":", zorder=2)
        axes.add_patch(Polygon(path, fill=False, edgecolor=EDGE, **style))
    style = dict(facecolor=situation.colour[i] / 255, edgecolor=EDGE, zorder=3)
    shape: Patch
    if vertices == 0:
        shape = Circle((x, y), radius, **style, **_KIND_STYLES[kind])
    else:
        angles = angle + 2 * math.pi * np.arange(vertices) / vertices
        outline = pose[:2] + radius * np.stack([np.cos(angles), np.sin(angles)], 1)
        shape = Polygon(outline, **style, **_KIND_STYLES[kind])
    axes.add_patch(shape)


def _draw_agent(axes: Axes, world: FlatlandWorld, poses: np.ndarray) -> None:
    agent = world.agent
    x, y, heading = poses[0]
    half = np.array([agent.arm_length, agent.arm_width]) / 2
    box = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * half
    style: dict[str, Any] = dict(edgecolor=EDGE, linewidth=0.8)
    for i in range(1, N_LINKS):
        cos, sin = math.cos(poses[i, 2]), math.sin(poses[i, 2])
        outline = box @ np.array([[cos, sin], [-sin, cos]]) + poses[i, :2]
        fill = ARM_COLOURS[i - 1] / 255
        axes.add_patch(Polygon(outline, facecolor=fill, zorder=4, **style))
    r = agent.base_radius
    axes.add_patch(Circle((x, y), r, facecolor=SKIN, edgecolor=EDGE, linewidth=1.0, zorder=5))
    nose = np.array([math.cos(heading), math.sin(heading)]) * r
    nose_x, nose_y = [x + 0.6 * nose[0], x + nose[0]], [y + 0.6 * nose[1], y + nose[1]]
    axes.plot(nose_x, nose_y, color=EDGE, linewidth=1.4, zorder=6)
    axes.add_patch(Circle((x, y), r * 0.4, facecolor="white", zorder=6, **style))
    gaze = heading + world.controller_state[HEAD]
    pupil = x + 0.2 * r * math.cos(gaze), y + 0.2 * r * math.sin(gaze)
    axes.add_patch(Circle(pupil, r * 0.15, facecolor="black", zorder=7))


def draw_view(axes: Axes, view: np.ndarray) -> None:
    """Draw a view, uint8 (pixels, 3), as a strip; its left side is the agent's left."""
    axes.imshow(view[None, ::-1], aspect="auto", interpolation="nearest")
    axes.set_xticks([])
    axes.set_yticks([])
    axes.spines[:].set_visible(True)
