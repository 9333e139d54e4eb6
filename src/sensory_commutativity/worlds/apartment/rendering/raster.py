"""Drawing triangles: compiled loops over the faces of what is in view, then over the samples of the picture.

Each face that is turned to the eye gets a matrix that takes a direction to its three homogeneous barycentric coordinates (Olano and Greer 1997,
"Triangle scan conversion using 2D homogeneous coordinates"): where all three are positive lies the face, their sum is the inverse depth, and no face
has to be cut at the near plane. First the nearest face at each sample is found, then every sample is coloured once. All arithmetic is sequential, so
the same scene gives the same picture, bit for bit.
"""

from __future__ import annotations

import math

import numpy as np

from ....compiled import njit
from .textures import SIZE

AMBIENT = 0.45
"""Brightness of a face that is turned away from the light; chosen: as indoors, by eye."""
LIGHT = np.array([0.35, 0.5, 0.79]) / math.sqrt(0.35**2 + 0.5**2 + 0.79**2)
"""Direction to the light, in the world's frame; chosen so that the walls of a room differ."""
BACKGROUND = (0.72, 0.80, 0.90)
"""Colour where there is nothing: sky."""
_INSIDE = -1e-9
"""What is so little outside of a face still belongs to it, so that rounding leaves no gap between two faces; far below a pixel."""


@njit()
def transform(drawables, vertices, poses, world):
    """Put the vertices of all drawables that move into the world: `world` float64 (n, 3) is filled."""
    for p in range(len(drawables)):
        body = drawables[p, 4]
        if body == 0:
            continue
        pose = poses[body]
        for i in range(drawables[p, 2], drawables[p, 3]):
            x, y, z = vertices[i, 0], vertices[i, 1], vertices[i, 2]
            for k in range(3):
                world[i, k] = pose[k, 0] * x + pose[k, 1] * y + pose[k, 2] * z + pose[k, 3]


@njit()
def rasterise(
    drawables,
    balls,
    faces,
    world,
    uv,
    poses,
    eye,
    light,
    width,
    height,
    focal,
    near,
    depth,
    index,
    planes,
    shades,
    slots,
):
    """Find the nearest face at every sample.

    Parameters
    ----------
    drawables : int64 (p, 5)
        First face, end of faces, first vertex, end of vertices, body of each piece.
    balls : float64 (p, 4)
        A ball around each piece, in its body's frame: middle, radius.
    faces, world, uv : int32 (f, 3), float64 (v, 3), float32 (f, 3, 2)
        Triangles, in the world.
    poses, eye : float64 (b, 4, 4), float64 (4, 4)
        Frames of the bodies and of the eye (x forward, y left, z up).
    light : float64 (3,)
        Direction to the light, of length 1.
    width, height, focal, near
        Samples, samples, samples per unit of tangent, metres.
    depth, index : float32 (height, width), int32 (height, width)
        Are filled: inverse depth; the place among the faces in view, -1 for none.
    planes, shades, slots : float64 (f, 9), float64 (f,), int64 (f,)
        Are filled for faces in view: coefficients of inverse depth and of both texture coordinates over it, brightness, number of the face.
    """
    depth[:] = 0.0
    index[:] = -1
    ex, ey, ez = eye[0, 3], eye[1, 3], eye[2, 3]
    half_x, half_y = width / 2, height / 2
    # Inward normals of the sides of the view, in the eye's axes right, down, forward: a ball is out of view if it is wholly behind one.
    side_x, side_y = (
        math.sqrt(focal * focal + half_x * half_x),
        math.sqrt(focal * focal + half_y * half_y),
    )
    corner = np.empty((3, 3))
    count = 0
    for p in range(len(drawables)):
        pose = poses[drawables[p, 4]]
        cx = (
            pose[0, 0] * balls[p, 0]
            + pose[0, 1] * balls[p, 1]
            + pose[0, 2] * balls[p, 2]
            + pose[0, 3]
            - ex
        )
        cy = (
            pose[1, 0] * balls[p, 0]
            + pose[1, 1] * balls[p, 1]
            + pose[1, 2] * balls[p, 2]
            + pose[1, 3]
            - ey
        )
        cz = (
            pose[2, 0] * balls[p, 0]
            + pose[2, 1] * balls[p, 1]
            + pose[2, 2] * balls[p, 2]
            + pose[2, 3]
            - ez
        )
        forward = eye[0, 0] * cx + eye[1, 0] * cy + eye[2, 0] * cz
        right = -(eye[0, 1] * cx + eye[1, 1] * cy + eye[2, 1] * cz)
        down = -(eye[0, 2] * cx + eye[1, 2] * cy + eye[2, 2] * cz)
        radius = balls[p, 3]
        if forward < near - radius:
            continue
        if (
            half_x * forward - focal * abs(right) < -radius * side_x
            or half_y * forward - focal * abs(down) < -radius * side_y
        ):
            continue
        for f in range(drawables[p, 0], drawables[p, 1]):
            a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
            ax, ay, az = world[a, 0] - ex, world[a, 1] - ey, world[a, 2] - ez
            ux, uy, uz = (
                world[b, 0] - world[a, 0],
                world[b, 1] - world[a, 1],
                world[b, 2] - world[a, 2],
            )
            vx, vy, vz = (
                world[c, 0] - world[a, 0],
                world[c, 1] - world[a, 1],
                world[c, 2] - world[a, 2],
            )
            nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
            if nx * ax + ny * ay + nz * az >= 0:
                continue  # turned away
            behind = 0
            for k in range(3):
                i = faces[f, k]
                x, y, z = world[i, 0] - ex, world[i, 1] - ey, world[i, 2] - ez
                corner[k, 0] = -(eye[0, 1] * x + eye[1, 1] * y + eye[2, 1] * z)
                corner[k, 1] = -(eye[0, 2] * x + eye[1, 2] * y + eye[2, 2] * z)
                corner[k, 2] = eye[0, 0] * x + eye[1, 0] * y + eye[2, 0] * z
                behind += corner[k, 2] < near
            if behind == 3:
                continue
            low_x, high_x, low_y, high_y = _bounds(corner, behind, focal, near)
            first_x, last_x = (
                max(0, math.ceil(low_x + half_x - 0.5)),
                min(width - 1, math.floor(high_x + half_x - 0.5)),
            )
            first_y, last_y = (
                max(0, math.ceil(low_y + half_y - 0.5)),
                min(height - 1, math.floor(high_y + half_y - 0.5)),
            )
            if first_x > last_x or first_y > last_y:
                continue
            if _draw(
                corner,
                uv[f],
                focal,
                near,
                half_x,
                half_y,
                first_x,
                last_x,
                first_y,
                last_y,
                depth,
                index,
                planes[count],
                count,
            ):
                length = math.sqrt(nx * nx + ny * ny + nz * nz)
                shades[count] = AMBIENT + (1 - AMBIENT) * (
                    0.5 + 0.5 * (nx * light[0] + ny * light[1] + nz * light[2]) / length
                )
                slots[count] = f
                count += 1


@njit()
def _bounds(corner, behind, focal, near):
    """Of what is before the near plane, in samples from the middle of the picture: lowest and highest x, lowest and highest y."""
    low_x = low_y = 1e18
    high_x = high_y = -1e18
    for k in range(3):
        z = corner[k, 2]
        if z >= near:
            x, y = focal * corner[k, 0] / z, focal * corner[k, 1] / z
            low_x, high_x, low_y, high_y = (
                min(low_x, x),
                max(high_x, x),
                min(low_y, y),
                max(high_y, y),
            )
        if behind > 0:
            j = (k + 1) % 3
            if (z >= near) != (corner[j, 2] >= near):
                t = (near - z) / (corner[j, 2] - z)
                x = focal * (corner[k, 0] + t * (corner[j, 0] - corner[k, 0])) / near
                y = focal * (corner[k, 1] + t * (corner[j, 1] - corner[k, 1])) / near
                low_x, high_x, low_y, high_y = (
                    min(low_x, x),
                    max(high_x, x),
                    min(low_y, y),
                    max(high_y, y),
                )
    return low_x, high_x, low_y, high_y


@njit()
def _draw(
    corner,
    uv,
    focal,
    near,
    half_x,
    half_y,
    first_x,
    last_x,
    first_y,
    last_y,
    depth,
    index,
    plane,
    slot,
):
    """Mark the samples where this face is the nearest so far, and note its plane; False if there is none."""
    ax, ay, az = corner[0]
    bx, by, bz = corner[1]
    cx, cy, cz = corner[2]
    # Rows of the inverse of the matrix with the corners as columns.
    r0x, r0y, r0z = by * cz - bz * cy, bz * cx - bx * cz, bx * cy - by * cx
    r1x, r1y, r1z = cy * az - cz * ay, cz * ax - cx * az, cx * ay - cy * ax
    r2x, r2y, r2z = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    determinant = ax * r0x + ay * r0y + az * r0z
    if abs(determinant) < 1e-14:
        return False
    s = 1.0 / determinant
    t = s / focal
    # Barycentric coordinates over depth, linear in sample coordinates: a x + b y + c.
    a0, b0, c0 = r0x * t, r0y * t, r0z * s
    a1, b1, c1 = r1x * t, r1y * t, r1z * s
    a2, b2, c2 = r2x * t, r2y * t, r2z * s
    da, db, dc = a0 + a1 + a2, b0 + b1 + b2, c0 + c1 + c2
    nearest = 1.0 / near
    marked = False
    for row in range(first_y, last_y + 1):
        y = row + 0.5 - half_y
        low, high = float(first_x), float(last_x)
        empty = False
        for k in range(3):
            if k == 0:
                a, v = a0, b0 * y + c0
            elif k == 1:
                a, v = a1, b1 * y + c1
            else:
                a, v = a2, b2 * y + c2
            v -= _INSIDE
            if a > 0:
                low = max(low, math.ceil(-v / a + half_x - 0.5))
            elif a < 0:
                high = min(high, math.floor(-v / a + half_x - 0.5))
            elif v < 0:
                empty = True
        if empty or low > high:
            continue
        start = int(low)
        inverse = da * (start + 0.5 - half_x) + db * y + dc
        for column in range(start, int(high) + 1):
            if inverse > depth[row, column] and inverse <= nearest:
                depth[row, column] = inverse
                index[row, column] = slot
                marked = True
            inverse += da
    if marked:
        plane[0], plane[1], plane[2] = da, db, dc
        for k in range(2):  # u, v
            plane[3 + 3 * k] = a0 * uv[0, k] + a1 * uv[1, k] + a2 * uv[2, k]
            plane[4 + 3 * k] = b0 * uv[0, k] + b1 * uv[1, k] + b2 * uv[2, k]
            plane[5 + 3 * k] = c0 * uv[0, k] + c1 * uv[1, k] + c2 * uv[2, k]
    return marked


@njit()
def colour(
    index,
    planes,
    shades,
    slots,
    colours,
    texture_of,
    textures,
    identities,
    supersampling,
    rgb,
    identity,
):
    """Colour every pixel: the mean of its samples; and tell what is seen at the sample in its middle (to the lower right, if their number is even).

    Parameters
    ----------
    colours, texture_of, identities : float32 (f, 3), int32 (f,), int32 (f,)
        Of the faces: colour in [0, 1], number of the texture or -1, what they are.
    textures : uint8 (t, 64, 64, 3)
    rgb, identity : uint8 (h, w, 3), int32 (h, w)
        Are filled.
    """
    height, width = identity.shape
    half_x, half_y = width * supersampling / 2, height * supersampling / 2
    scale = 255.0 / (supersampling * supersampling)
    for row in range(height):
        for column in range(width):
            red = green = blue = 0.0
            for i in range(supersampling):
                y = row * supersampling + i + 0.5 - half_y
                for j in range(supersampling):
                    slot = index[row * supersampling + i, column * supersampling + j]
                    if slot < 0:
                        red += BACKGROUND[0]
                        green += BACKGROUND[1]
                        blue += BACKGROUND[2]
                        continue
                    f = slots[slot]
                    shade = shades[slot]
                    t = texture_of[f]
                    if t >= 0:
                        x = column * supersampling + j + 0.5 - half_x
                        plane = planes[slot]
                        z = 1.0 / (plane[0] * x + plane[1] * y + plane[2])
                        u = (plane[3] * x + plane[4] * y + plane[5]) * z
                        v = (plane[6] * x + plane[7] * y + plane[8]) * z
                        texel = textures[
                            t, math.floor(v * SIZE) & (SIZE - 1), math.floor(u * SIZE) & (SIZE - 1)
                        ]
                        shade /= 255.0
                        red += shade * colours[f, 0] * texel[0]
                        green += shade * colours[f, 1] * texel[1]
                        blue += shade * colours[f, 2] * texel[2]
                    else:
                        red += shade * colours[f, 0]
                        green += shade * colours[f, 1]
                        blue += shade * colours[f, 2]
            rgb[row, column, 0] = int(min(red * scale + 0.5, 255.0))
            rgb[row, column, 1] = int(min(green * scale + 0.5, 255.0))
            rgb[row, column, 2] = int(min(blue * scale + 0.5, 255.0))
            slot = index[
                row * supersampling + supersampling // 2,
                column * supersampling + supersampling // 2,
            ]
            identity[row, column] = identities[slots[slot]] if slot >= 0 else 0
