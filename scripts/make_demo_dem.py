"""Writes the Jacksboro fault SRTM grid of Debian's python-matplotlib-data as a GeoTIFF.

Usage: /usr/bin/python3 scripts/make_demo_dem.py OUT.tif
"""

import sys

import numpy as np
from osgeo import gdal, osr

SOURCE = "/usr/share/matplotlib/mpl-data/sample_data/jacksboro_fault_dem.npz"


def main() -> None:
    if len(sys.argv) != 2 or sys.argv[1] in ("-h", "--help"):
        print(__doc__.strip())
        sys.exit(0 if sys.argv[1:] in (["-h"], ["--help"]) else 2)
    gdal.UseExceptions()
    osr.UseExceptions()

    grid = np.load(SOURCE)
    elevation = grid["elevation"]
    rows, columns = elevation.shape
    dx, dy = float(grid["dx"]), float(grid["dy"])
    # The extent is that of the pixels' outer corners: columns * dx wide, and half a step off SRTM's samples,
    # which lie on whole multiples of dx. The keys ymin and ymax are swapped; the first row is the northern one.
    west, east = float(grid["xmin"]), float(grid["xmax"])
    north, south = float(grid["ymin"]), float(grid["ymax"])
    assert abs(east - west - columns * dx) < dx / 100 and abs(north - south - rows * dy) < dy / 100

    crs = osr.SpatialReference()
    crs.ImportFromEPSG(4326)
    raster = gdal.GetDriverByName("GTiff").Create(
        sys.argv[1], columns, rows, 1, gdal.GDT_Int16, ["TILED=YES", "COMPRESS=DEFLATE"]
    )
    raster.SetGeoTransform([west, dx, 0, north, 0, -dy])
    raster.SetProjection(crs.ExportToWkt())
    band = raster.GetRasterBand(1)
    band.SetUnitType("m")
    band.WriteArray(elevation)
    raster.FlushCache()
    print(f"{sys.argv[1]}: {columns} x {rows} samples, {elevation.min()} to {elevation.max()} m")


if __name__ == "__main__":
    main()
