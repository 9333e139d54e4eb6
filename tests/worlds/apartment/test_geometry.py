"""Meshes are closed and of the right volume; mesh files are read and decimated."""

from __future__ import annotations

import math

import numpy as np
import pytest
import trimesh

from sensory_commutativity.worlds.apartment import geometry
from sensory_commutativity.worlds.apartment.meshfiles import load_mesh

CUP = [(0, 0), (1, 0), (1, 2), (0.9, 2), (0.9, 0.1), (0, 0.1)]


def test_meshes_are_closed_and_face_outwards():
    cases = {
        "box": (geometry.box((0.5, 1.0, 1.5)), 6.0),
        "panel": (geometry.panel((0.5, 1.0, 1.5)), 6.0),
        "cylinder": (geometry.cylinder(0.5, 1.0, 96), math.pi * 0.25 * 2),
        "sphere": (geometry.sphere(1.0, 48, 96), 4 / 3 * math.pi),
        "lathe": (geometry.lathe(CUP, 96), math.pi * (2 - 0.81 * 1.9)),
        "handle": (geometry.handle(0.03, 0.01, 32, 24), math.pi * 0.03 * math.pi * 0.005**2),
    }
    for name, (mesh, volume) in cases.items():
        assert geometry.volume(mesh) == pytest.approx(volume, rel=0.02), name
        edges = [mesh.faces[:, [0, 1]], mesh.faces[:, [1, 2]], mesh.faces[:, [2, 0]]]
        counts = np.unique(np.sort(np.concatenate(edges), 1), axis=0, return_counts=True)[1]
        assert (counts == 2).all(), name
        assert mesh.uv.shape == (len(mesh.faces), 3, 2), name


def test_a_mesh_file_is_read_and_decimated(tmp_path):
    trimesh.creation.icosphere(subdivisions=3, radius=2.0).export(tmp_path / "ball.stl")
    full = load_mesh(tmp_path / "ball.stl")
    decimated = load_mesh(tmp_path / "ball.stl", 100)
    assert len(full.faces) == 1280
    assert len(decimated.faces) <= 110
    assert geometry.volume(full) == pytest.approx(33.1, rel=0.02)
    assert geometry.volume(decimated) == pytest.approx(33.1, rel=0.2)
