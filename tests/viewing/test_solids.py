"""Meshes for the viewer: closed, outward, and as large as the shape."""

import numpy as np
import pytest

from pivotgait.plotting import mesh
from pivotgait.viewing.solids import rgb, triangulate

SOLIDS = {
    "capsule": mesh.capsule(0.01, 0.05),
    "cylinder": mesh.cylinder(0.02, 0.01),
    "box": mesh.box((0.01, 0.02, 0.03)),
}


@pytest.mark.parametrize("name", SOLIDS)
def test_every_edge_has_two_triangles_that_run_it_both_ways(name):
    _, triangles = triangulate(SOLIDS[name])
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    assert len(np.unique(edges, axis=0)) == len(edges)
    assert {tuple(edge) for edge in edges} == {tuple(edge) for edge in edges[:, ::-1]}


@pytest.mark.parametrize("name", SOLIDS)
def test_triangles_enclose_the_volume_of_the_quads(name):
    vertices, triangles = triangulate(SOLIDS[name])
    a, b, c = vertices[triangles].transpose(1, 0, 2)
    volume = np.einsum("fi,fi->", a, np.cross(b, c)) / 6
    a, b, c, d = np.moveaxis(SOLIDS[name], 1, 0)
    quads = sum(np.einsum("fi,fi->", p, np.cross(q, r)) for p, q, r in ((a, b, c), (a, c, d))) / 6
    assert volume == pytest.approx(quads, rel=1e-6)
    assert volume > 0.0


def test_colours_keep_their_order():
    assert rgb("#D55E00") == (0xD5, 0x5E, 0x00)
