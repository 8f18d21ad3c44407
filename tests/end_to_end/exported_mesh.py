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
from mesh import in_surface, paint, read_ply
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
            mesh = paint(vertices[:, 0] / 10, vertices[:, 1] / -10, vertices[:, 2], faces, heights.shape)
            assert (np.isnan(mesh) == ~surface).all(), f"level {level} does not cover the surface exactly"
            error = np.nanmax(np.abs(mesh - heights))
            bound = 5 * 2.0 ** (levels - 1 - level)
            print(f"level {level}: {len(faces)} triangles, {error:.4f} m at the samples, bound {bound} m")
            assert 0 < error <= bound, f"level {level}: {error} m exceeds {bound} m"


main()
