#!/usr/bin/env python3
"""gaussian_pyramid.py DEM [LEVELS]: how far the levels of a pyramid of averages are from the DEM itself.

Dick et al. (2009) mesh level l of a Gaussian pyramid, averages of 2 x 2 samples, within its sample spacing of that level's
own heights. This prints the largest distance between the level's surface, no triangle left out, and the DEM's samples: what is to
be added to that tolerance. The DEM must be projected and without nodata."""
import sys

import numpy as np
from osgeo import gdal

gdal.UseExceptions()


def averaged(heights):
    rows, columns = (n // 2 * 2 for n in heights.shape)
    h = heights[:rows, :columns]
    return (h[0::2, 0::2] + h[0::2, 1::2] + h[1::2, 0::2] + h[1::2, 1::2]) / 4


def sampled(heights, column, row):
    """The heights' triangulated surface, diagonals from north-west to south-east, at columns x rows of places."""
    x0 = np.clip(np.floor(column).astype(int), 0, heights.shape[1] - 2)
    y0 = np.clip(np.floor(row).astype(int), 0, heights.shape[0] - 2)
    fx, fy = np.meshgrid(column - x0, row - y0)
    x, y = np.meshgrid(x0, y0)
    nw, ne, sw, se = heights[y, x], heights[y, x + 1], heights[y + 1, x], heights[y + 1, x + 1]
    return np.where(fx >= fy, nw + fx * (ne - nw) + fy * (se - ne), nw + fy * (sw - nw) + fx * (se - sw))


def main(path, levels=5):
    dem = gdal.Open(path)
    transform = dem.GetGeoTransform()
    spacing = (abs(transform[1]) * abs(transform[5])) ** 0.5
    heights = dem.ReadAsArray().astype(float)
    level = heights
    print(f"{'level':>5} {'spacing = tolerance, m':>22} {'level to DEM, m':>16} {'true bound, tolerances':>22}")
    for number in range(1, levels + 1):
        level = averaged(level)
        step = 2**number
        # A level's sample lies in the middle of its block; beyond the outermost ones there is no surface.
        first = (step - 1) / 2
        columns = np.arange(int(np.ceil(first)), int(first + (level.shape[1] - 1) * step) + 1)
        rows = np.arange(int(np.ceil(first)), int(first + (level.shape[0] - 1) * step) + 1)
        off = np.abs(sampled(level, (columns - first) / step, (rows - first) / step) - heights[np.ix_(rows, columns)]).max()
        print(f"{number:5d} {step * spacing:22.1f} {off:16.1f} {1 + off / (step * spacing):22.2f}")


if __name__ == "__main__":
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    main(sys.argv[1], *map(int, sys.argv[2:]))
