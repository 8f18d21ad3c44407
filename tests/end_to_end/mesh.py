"""Exported meshes and the surface they stand for, in numpy alone."""
import math

import numpy as np


def read_ply(path):
    with open(path, "rb") as f:
        counts = {}
        while (line := f.readline().decode().strip()) != "end_header":
            if line.startswith("element"):
                counts[line.split()[1]] = int(line.split()[2])
        vertices = np.frombuffer(f.read(24 * counts["vertex"]), "<f8").reshape(-1, 3)
        face = np.dtype([("n", "u1"), ("v", "<u4", 3)])
        faces = np.frombuffer(f.read(face.itemsize * counts["face"]), face)
    assert (faces["n"] == 3).all()
    return vertices, faces["v"]


def paint(columns, rows, heights, faces, shape):
    """The mesh's height at every sample it covers, and NaN elsewhere. Vertices are given by place on the grid."""
    out = np.full(shape, np.nan)
    for face in faces:
        cx, cy, z = columns[face], rows[face], heights[face]
        i0, i1 = math.ceil(cx.min() - 1e-9), math.floor(cx.max() + 1e-9)
        j0, j1 = math.ceil(cy.min() - 1e-9), math.floor(cy.max() + 1e-9)
        if i0 > i1 or j0 > j1:
            continue
        j, i = np.mgrid[j0 : j1 + 1, i0 : i1 + 1]
        d = (cx[0] - cx[2]) * (cy[1] - cy[2]) - (cx[1] - cx[2]) * (cy[0] - cy[2])
        a = ((cy[1] - cy[2]) * (i - cx[2]) + (cx[2] - cx[1]) * (j - cy[2])) / d
        b = ((cy[2] - cy[0]) * (i - cx[2]) + (cx[0] - cx[2]) * (j - cy[2])) / d
        inside = (a > -1e-9) & (b > -1e-9) & (a + b < 1 + 1e-9)
        out[j[inside], i[inside]] = (a * z[0] + b * z[1] + (1 - a - b) * z[2])[inside]
    return out


def in_surface(heights):
    """Samples that belong to a triangle of the surface."""
    valid = ~np.isnan(heights)
    nw, ne, sw, se = valid[:-1, :-1], valid[:-1, 1:], valid[1:, :-1], valid[1:, 1:]
    out = np.zeros_like(valid)
    south, north = nw & sw & se, nw & se & ne
    for triangle, corners in ((south, ((0, 0), (1, 0), (1, 1))), (north, ((0, 0), (1, 1), (0, 1)))):
        for j, i in corners:
            out[j : out.shape[0] - 1 + j, i : out.shape[1] - 1 + i] |= triangle
    return out
