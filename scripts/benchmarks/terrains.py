"""The terrains of the atlas: made ones by name (build/bench/tests/make_terrain), and windows of real DEMs."""
import re
import struct
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from osgeo import gdal, osr

from datasets import Raster, made
from programs import BENCH, run

MAKE_TERRAIN = BENCH / "tests" / "make_terrain"
FOLDER = BENCH / "atlas"

#: The error that is asked for, metres, where half the sample spacing would say nothing.
ERRORS_M = {
    "checkerboard": 1, "white_noise": 10, "ridges": 1, "cliff": 2, "steps": 2, "steep_slope": 2, "spike": 5, "pit": 5,
    "far_above": 2, "hills": 1, "odd": 1, "ribbon": 1, "saddles": 1, "flat": 0.01, "slope": 0.01, "slope_off_lattice": 0.01,
    "million_above": 0.005, "million_below": 0.005, "million_apart": 2, "plateaus_apart": 4, "wall": 2, "rough_wall": 2,
    "gentle_slope": 0.002, "tiny_spacing": 5e-5, "tiny_spacing_steep": 0.5, "huge_spacing": 100, "micrometres": 2e-7,
}  # fmt: skip


@dataclass(frozen=True)
class Terrain:
    name: str
    family: str
    about: str
    columns: int
    rows: int
    error_m: float | None = None  # None: half the spacing


@dataclass(frozen=True)
class Window:
    """Of a real DEM. `metre`: how long a unit of its heights is."""

    about: str
    file: str
    column: int
    row: int
    side: int
    error_m: float
    metre: float = 1


#: Windows on which simplifiers have a hard time.
WINDOWS = {
    "sierra": Window("granite walls of the Sierra Nevada, 3 arc-seconds", "calif_13201x4801.tif", 6300, 1500, 257, 8),
    "moon": Window("craters, 118 m", "moon_8193.tif", 3000, 3000, 257, 12),
    "everest": Window("Himalayan walls with voids, 3 arc-seconds", "mt_everest_90m.tif", 500, 500, 257, 10),
    "autzen": Window("a stadium and trees, LiDAR at 2 feet with voids", "autzen_dsm_2ft_raw.tif", 700, 900, 257, 0.3, 0.3048),
}
QUICK = ("cliff", "ridges", "spike", "holes_5", "rough_wall", "million_above")


def listed():
    """All terrains that make_terrain makes."""
    lines = run(MAKE_TERRAIN).output.splitlines()
    found = [re.fullmatch(r"(\w+) +(\w+) +(\d+) x (\d+) +(.*)", line) for line in lines]
    return [Terrain(m[1], m[2], m[5], int(m[3]), int(m[4]), ERRORS_M.get(m[1])) for m in found]


def real(data):
    return [Terrain(name, "real", w.about, w.side, w.side, w.error_m) for name, w in WINDOWS.items() if (Path(data) / w.file).exists()]


def raster_of(terrain, data):
    """The terrain as a file of metres."""

    def write(partial):
        if terrain.family == "real":
            _write_window(partial, WINDOWS[terrain.name], data)
        else:
            run(MAKE_TERRAIN, terrain.name, partial)

    return Raster(terrain.name, made(FOLDER / f"{terrain.name}.tif", write))


def _write_window(path, window, data):
    source = gdal.Open(str(Path(data) / window.file))
    dx, dy = Raster(window.file, Path(data) / window.file).spacing_m
    band = source.GetRasterBand(1)
    heights = band.ReadAsArray(window.column, window.row, window.side, window.side).astype(np.float64)
    missing = heights == band.GetNoDataValue()
    raster = gdal.GetDriverByName("GTiff").Create(str(path), window.side, window.side, 1, gdal.GDT_Float64)
    raster.SetGeoTransform((500000, dx, 0, 4000000, 0, -dy))
    utm = osr.SpatialReference()
    utm.ImportFromEPSG(32610)
    raster.SetProjection(utm.ExportToWkt())
    raster.GetRasterBand(1).SetNoDataValue(-9999)
    raster.GetRasterBand(1).WriteArray(np.where(missing, -9999, heights * window.metre))


def error_of(terrain, raster):
    return terrain.error_m or 0.5 * raster.mean_spacing_m


def fingerprint(raster):
    """What a result depends on of the terrain."""
    heights, valid = raster.heights()
    return struct.pack("<2q2d", *raster.size, *raster.spacing_m) + heights.tobytes() + valid.tobytes()
