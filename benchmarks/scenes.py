"""Load mesh scenes as people ship them, with time and memory, and draw what a camera sees of each.

    python benchmarks/scenes.py docs/images/scenes.png

Every scene is made from the furniture of rs-stand-in: as OBJ with a texture, GLB with materials,
PLY with vertex colours, with faces of mixed orientation, and as a noisy scan of 250,000 faces.
"""

from __future__ import annotations

import resource
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import trimesh
from matplotlib.figure import Figure
from PIL import Image

from sensory_commutativity.data import data_file
from sensory_commutativity.worlds.apartment.physics.simulation import Simulation
from sensory_commutativity.worlds.apartment.rendering.camera import (
    Camera,
    Drawable,
    Renderer,
    look_at,
)
from sensory_commutativity.worlds.apartment.robots.loading import load_robot
from sensory_commutativity.worlds.apartment.scenes.scene import Scene
from sensory_commutativity.worlds.apartment.scenes.scenefile import load_scene

SCAN_FACES = 250_000
PIXELS = 256


def list_parts(scene: Scene) -> list[tuple[trimesh.Trimesh, np.ndarray]]:
    """Meshes of the fixtures below the ceiling, and their colours."""
    return [
        (trimesh.Trimesh(part.mesh.vertices, part.mesh.faces, process=False), np.array(part.colour))
        for fixture in scene.fixtures
        if not fixture.overhead
        for part in fixture.parts
    ]


def write_materials(parts: list, path: Path) -> None:
    """GLB with a material for each part."""
    scene = trimesh.Scene()
    for mesh, colour in parts:
        material = trimesh.visual.material.PBRMaterial(baseColorFactor=[*colour, 1.0])
        mesh = mesh.copy()
        mesh.visual = trimesh.visual.TextureVisuals(material=material)
        scene.add_geometry(mesh)
    scene.export(path)


def write_vertex_colours(parts: list, path: Path) -> None:
    """PLY with the colour of each vertex."""
    meshes = []
    for mesh, colour in parts:
        mesh = mesh.copy()
        mesh.visual.vertex_colors = np.append(colour * 255, 255).astype(np.uint8)
        meshes.append(mesh)
    trimesh.util.concatenate(meshes).export(path)


def write_mixed(parts: list, path: Path) -> None:
    """As vertex colours, with every second face turned over."""
    write_vertex_colours(parts, path)
    mesh = trimesh.load_mesh(path, process=False)
    mesh.faces[::2] = mesh.faces[::2, ::-1]
    mesh.export(path)


def write_texture(parts: list, path: Path) -> None:
    """OBJ in which every part takes its colour from a palette picture."""
    side = int(np.ceil(np.sqrt(len(parts))))
    pixels = np.zeros((side, side, 3), np.uint8)
    pixels.reshape(-1, 3)[: len(parts)] = [colour * 255 for _, colour in parts]
    Image.fromarray(pixels).quantize(256).save(path.with_suffix(".png"))
    path.with_suffix(".mtl").write_text(f"newmtl all\nmap_Kd {path.stem}.png\n")
    lines, start = [f"mtllib {path.stem}.mtl", "usemtl all"], 1
    for i, (mesh, _) in enumerate(parts):
        row, column = divmod(i, side)
        lines += [f"v {x} {y} {z}" for x, y, z in mesh.vertices]
        lines.append(f"vt {(column + 0.5) / side} {1 - (row + 0.5) / side}")
        lines += [
            "f " + " ".join(f"{v}/{i + 1}" for v in face) for face in np.asarray(mesh.faces) + start
        ]
        start += len(mesh.vertices)
    path.write_text("\n".join(lines) + "\n")


def write_scan(parts: list, path: Path) -> None:
    """PLY of SCAN_FACES faces whose vertices are 3 mm off, with noisy colours."""
    rng = np.random.default_rng(0)
    total = sum(mesh.area for mesh, _ in parts)
    meshes = []
    for mesh, colour in parts:
        mesh = mesh.copy()
        longest = np.sqrt(4 * total / SCAN_FACES)
        for _ in range(12):
            if len(mesh.faces) >= SCAN_FACES * mesh.area / total:
                break
            mesh = mesh.subdivide()
        vertices = mesh.vertices + rng.normal(0, min(0.003, longest / 10), mesh.vertices.shape)
        mesh = trimesh.Trimesh(vertices, mesh.faces, process=False)
        noisy = np.clip(colour + rng.normal(0, 0.04, (len(vertices), 3)), 0, 1)
        mesh.visual.vertex_colors = np.column_stack([noisy, np.ones(len(noisy))])
        meshes.append(mesh)
    trimesh.util.concatenate(meshes).export(path)


SCENES = {
    "OBJ, texture with a palette": ("obj", write_texture),
    "GLB, materials": ("glb", write_materials),
    "PLY, vertex colours": ("ply", write_vertex_colours),
    "PLY, faces of mixed orientation": ("ply", write_mixed),
    "PLY, a scan": ("ply", write_scan),
}


def main(out: Path) -> None:
    parts = list_parts(load_scene(data_file("config", "apartments", "rs-stand-in.yaml")))
    robot = load_robot(data_file("config", "robots", "jackrabbot.yaml"))
    figure = Figure(figsize=(3 * len(SCENES), 3.4), layout="constrained")
    with tempfile.TemporaryDirectory() as folder:
        for i, (title, (suffix, write)) in enumerate(SCENES.items()):
            file = Path(folder) / f"scene-{i}.{suffix}"
            write(parts, file)
            description = file.with_suffix(".yaml")
            description.write_text(f"kind: mesh\nname: scene-{i}\nmesh: {file.name}\n")
            start = time.process_time()
            scene = load_scene(description)
            simulation = Simulation(scene, robot)
            seconds = time.process_time() - start
            simulation.close()
            faces = sum(len(part.mesh.faces) for part in scene.fixtures[0].parts)
            memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
            print(f"{title}: {faces:,} faces, {seconds:.1f} s, {memory:.2f} GB at most so far")
            drawables = [Drawable(part, 1, 0) for part in scene.fixtures[0].parts]
            renderer = Renderer(drawables, 1)
            view = look_at((1.0, 1.0, 1.5), (4.0, 3.2, 0.8))
            image = renderer.render(Camera(PIXELS, PIXELS, 75.0), view, np.eye(4)[None]).rgb
            axes = figure.add_subplot(1, len(SCENES), i + 1)
            axes.imshow(image)
            axes.set_title(f"{title}\n{faces:,} faces", fontsize="small")
            axes.set_axis_off()
    figure.savefig(out, dpi=110, bbox_inches="tight")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
