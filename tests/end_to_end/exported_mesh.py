"""Builds a tree, exports every level, and checks the meshes at every sample with numpy and GDAL alone.

usage: exported_mesh.py BIN_DIR
The DEM is made here: waves and noise with a cliff, a sea and holes.
"""
import math
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from osgeo import gdal

gdal.UseExceptions()


def make_dem(path):
    rows, columns = 300, 417
    y, x = np.mgrid[0:rows, 0:columns]
    heights = 80 * np.sin(x / 23.0) * np.cos(y / 31.0) + np.random.default_rng(7).normal(0, 2, (rows, columns))
    heights[(x + 2 * y) > 700] += 150  # a cliff
    heights[heights < -60] = -60  # a sea
    heights[100:140, 200:230] = -9999
    heights[(x - 60) ** 2 + (y - 256) ** 2 < 90] = -9999  # across the sides of tiles
    raster = gdal.GetDriverByName("GTiff").Create(str(path), columns, rows, 1, gdal.GDT_Float32)
    raster.SetGeoTransform((500000, 10, 0, 4000000, 0, -10))
    raster.GetRasterBand(1).SetNoDataValue(-9999)
    raster.GetRasterBand(1).WriteArray(heights)


def read_dem(path):
    raster = gdal.Open(str(path))
    band = raster.GetRasterBand(1)
    heights = band.ReadAsArray().astype(np.float64)
    if band.GetNoDataValue() is not None:
        heights[heights == band.GetNoDataValue()] = np.nan
    return heights


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


def paint(vertices, faces, shape, dx, dy):
    """The mesh's height at every sample it covers, and NaN elsewhere."""
    out = np.full(shape, np.nan)
    columns, rows = vertices[:, 0] / dx, -vertices[:, 1] / dy
    for face in faces:
        cx, cy, z = columns[face], rows[face], vertices[face, 2]
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


def main():
    bin_dir = Path(sys.argv[1])
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        dem = folder / "dem.tif"
        make_dem(dem)
        tree, report = folder / "t.tintree", folder / "t.json"
        command = [bin_dir / "tintree-build", dem, "-o", tree, "--error", "5", "--tile", "64", "--quiet", "--json", report]
        subprocess.run(command, check=True)
        heights = read_dem(dem)
        surface = in_surface(heights)
        levels = math.ceil(math.log2((max(heights.shape) - 1) / 64)) + 1
        for level in range(levels):
            ply = folder / f"{level}.ply"
            subprocess.run([bin_dir / "tintree-export", tree, "--to", "ply", "--level", str(level), "-o", ply, "--quiet"], check=True)
            vertices, faces = read_ply(ply)
            mesh = paint(vertices, faces, heights.shape, 10, 10)
            assert (np.isnan(mesh) == ~surface).all(), f"level {level} does not cover the surface exactly"
            error = np.nanmax(np.abs(mesh - heights))
            bound = 5 * 2.0 ** (levels - 1 - level)
            print(f"level {level}: {len(faces)} triangles, {error:.4f} m at the samples, bound {bound} m")
            assert 0 < error <= bound, f"level {level}: {error} m exceeds {bound} m"


main()
