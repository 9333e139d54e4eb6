"""The eye: a compiled ray caster that turns a flat world into a line of RGB pixels.

Each pixel is one ray through its middle; equal angles lie between neighbours. A pixel has the colour of the first thing that its ray hits and
is black where it hits nothing, without shading (as in the authors' simulator). Everything is first turned into the eye's own frame, so that
what is seen depends on nothing but where things are relative to the eye.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...compiled import njit


def ray_directions(pixels: int, field_of_view: float) -> np.ndarray:
    """Unit vectors of the rays in the eye's frame (x ahead, y left), from right to left: float64 (pixels, 2)."""
    angles = field_of_view * ((np.arange(pixels) + 0.5) / pixels - 0.5)
    return np.stack([np.cos(angles), np.sin(angles)], 1)


class Scene(NamedTuple):
    """All that the eye needs to know and that never changes while the world moves; `n` things, the agent's arms among them, and `m` walls."""

    rays: np.ndarray  # float64 (pixels, 2), from ray_directions
    field_of_view: float  # rad
    view_range: float  # units
    outlines: np.ndarray  # float64 (n, corners, 2): corners of each thing in its own frame, counter-clockwise; not read for discs
    vertices: np.ndarray  # int64 (n,): number of corners; 0 for a disc
    radius: np.ndarray  # float64 (n,): radius of a disc, or of the circle about a polygon
    colour: np.ndarray  # uint8 (n, 3)
    walls: np.ndarray  # float64 (m, 4): end points (x1, y1, x2, y2), the first on the left as seen from inside the room
    wall_colour: np.ndarray  # uint8 (m, 3)


@njit()
def look(scene, eye, eyelid, pose, out):
    """Cast all rays and write what they see.

    Parameters
    ----------
    scene : Scene
    eye : (x, y, heading), float; units, rad
    eyelid : float in [0, 2]
        What is seen is multiplied by it and clipped to 255.
    pose : float64 (n, 3), (x, y, angle) of each thing; units, rad
    out : uint8 (pixels, 3), written
    """
    x, y, heading = eye
    rays, field_of_view, view_range = scene.rays, scene.field_of_view, scene.view_range
    outlines, vertices, radius, walls = scene.outlines, scene.vertices, scene.radius, scene.walls
    pixels = rays.shape[0]
    ahead_x, ahead_y = math.cos(heading), math.sin(heading)
    step = field_of_view / pixels
    depth = np.full(pixels, view_range)
    hit = np.full(pixels, -1)
    corner = np.empty((outlines.shape[1], 2))

    for i in range(walls.shape[0]):
        ax, ay = walls[i, 0] - x, walls[i, 1] - y
        bx, by = walls[i, 2] - x, walls[i, 3] - y
        _cast_segment(
            rays, 0, pixels, step, field_of_view, ax * ahead_x + ay * ahead_y, ay * ahead_x - ax * ahead_y,
            bx * ahead_x + by * ahead_y, by * ahead_x - bx * ahead_y, len(vertices) + i, depth, hit,
        )  # fmt: skip

    for i in range(len(vertices)):
        dx, dy = pose[i, 0] - x, pose[i, 1] - y
        cx, cy = dx * ahead_x + dy * ahead_y, dy * ahead_x - dx * ahead_y
        first, last = _pixels_covered(cx, cy, radius[i], pixels, step, field_of_view, view_range)
        if first >= last:
            continue
        if vertices[i] == 0:
            _cast_disc(rays, first, last, cx, cy, radius[i], i, depth, hit)
            continue
        cos, sin = math.cos(pose[i, 2] - heading), math.sin(pose[i, 2] - heading)
        for k in range(vertices[i]):
            corner[k, 0] = cx + cos * outlines[i, k, 0] - sin * outlines[i, k, 1]
            corner[k, 1] = cy + sin * outlines[i, k, 0] + cos * outlines[i, k, 1]
        for k in range(vertices[i]):
            following = (k + 1) % vertices[i]
            _cast_segment(
                rays, first, last, step, field_of_view,
                corner[k, 0], corner[k, 1], corner[following, 0], corner[following, 1], i, depth, hit,
            )  # fmt: skip

    shown = np.empty((len(vertices) + walls.shape[0], 3), np.uint8)  # colours through the eyelid
    for i in range(shown.shape[0]):
        for channel in range(3):
            value = (
                scene.colour[i, channel]
                if i < len(vertices)
                else scene.wall_colour[i - len(vertices), channel]
            )
            shown[i, channel] = np.uint8(min(255.0, value * eyelid + 0.5))
    for j in range(pixels):
        if hit[j] < 0:
            out[j, 0] = out[j, 1] = out[j, 2] = 0
        else:
            out[j, 0], out[j, 1], out[j, 2] = shown[hit[j], 0], shown[hit[j], 1], shown[hit[j], 2]


@njit()
def _pixels_covered(cx, cy, radius, pixels, step, field_of_view, view_range):
    """Half-open range of pixels whose rays may hit the disc of `radius` about (cx, cy); empty when it is out of sight."""
    distance = math.hypot(cx, cy)
    if distance - radius > view_range:
        return 0, 0
    if distance <= radius or field_of_view > math.pi:
        return 0, pixels
    middle, half = math.atan2(cy, cx), math.asin(radius / distance)
    return _pixels_between(middle - half, middle + half, pixels, step, field_of_view)


@njit()
def _pixels_between(low, high, pixels, step, field_of_view):
    """Half-open range of pixels whose rays lie between two directions, rad, widened by a pixel for rounding."""
    first = math.floor((low + field_of_view / 2) / step - 0.5)
    last = math.ceil((high + field_of_view / 2) / step - 0.5) + 1
    return max(0, first), min(pixels, last)


@njit()
def _cast_disc(rays, first, last, cx, cy, radius, index, depth, hit):
    outside = cx * cx + cy * cy - radius * radius
    for j in range(first, last):
        along = cx * rays[j, 0] + cy * rays[j, 1]
        discriminant = along * along - outside
        if discriminant >= 0:
            t = along - math.sqrt(discriminant)
            if 0 <= t < depth[j]:
                depth[j], hit[j] = t, index


@njit()
def _cast_segment(rays, first, last, step, field_of_view, ax, ay, bx, by, index, depth, hit):
    """The segment from a to b, seen with a on the left: from the other side it is not seen."""
    ex, ey = bx - ax, by - ay
    cross = ay * ex - ax * ey
    if cross <= 0:
        return
    if last - first > 8:  # worth two arc tangents
        left, right = math.atan2(ay, ax), math.atan2(by, bx)
        if left >= right:  # otherwise the segment crosses the direction straight behind
            low, high = _pixels_between(right, left, len(rays), step, field_of_view)
            first, last = max(first, low), min(last, high)
    for j in range(first, last):
        rx, ry = rays[j, 0], rays[j, 1]
        denominator = ry * ex - rx * ey
        if denominator > 0:
            along = ay * rx - ax * ry
            if 0 <= along <= denominator and cross < depth[j] * denominator:
                depth[j], hit[j] = cross / denominator, index
