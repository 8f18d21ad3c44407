"""The terrains that are charted: square windows of real DEMs, in whole metres and without holes.

Holes are filled by interpolation (GDAL's FillNodata) for all methods alike. Where a DEM is finer than whole metres a
model of it is measured that is `scale` times as large, and lengths are divided by that in the end: so every program
gets the same whole numbers."""
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from osgeo import gdal, osr

from datasets import Raster, crop, made, mirrored, whole
from programs import CACHE

gdal.UseExceptions()

SIDE, QUICK_SIDE = 1025, 513  # 2^k + 1, which martini needs


@dataclass(frozen=True)
class Window:
    name: str
    file: str
    column: int  # of the north-west corner
    row: int
    about: str
    scale: int = 1
    unit_m: float = 1.0  # of the file's heights; only where scaled
    pixel_m: float = 0.0


WINDOWS = [
    Window("moon", "moon_8193.tif", 0, 0, "craters, 118 m"),
    Window("california", "calif_13201x4801.tif", 6000, 1000, "the Sierra Nevada, 3\""),
    Window("rainier", "mt_rainier_90m.tif", 88, 88, "a volcano, 3\", 0.6 % filled"),
    Window("autzen", "autzen_dsm_2ft_raw.tif", 224, 103, "a stadium and trees, 2 ft, 3 % filled; a model 128 times as large",
           scale=128, unit_m=0.3048, pixel_m=0.6096),
]


@dataclass(frozen=True)
class Size:
    """The Moon from its north-west corner, continued by its mirror images where it ends."""
    columns: int
    rows: int
    name: str = "moon"

    @property
    def samples(self):
        return self.columns * self.rows


_WHOLE = 8193  # samples a side of the Moon
SIZES = [Size(1025, 1025), Size(2049, 2049), Size(4097, 4097), Size(_WHOLE, _WHOLE), Size(2 * _WHOLE - 1, 2 * _WHOLE - 1),
         Size(4 * _WHOLE - 3, 2 * _WHOLE - 1)]
QUICK_SIZES = SIZES[1:2]


def size_raster(size, data):
    """None where the data set is missing."""
    if not whole(data, size.name).path.exists():
        return None
    if size.columns < _WHOLE:
        return crop(data, size.name, size.columns, size.rows)
    if size.columns == _WHOLE:
        return whole(data, size.name)
    return mirrored(data, size.name, (size.columns - 1) // (_WHOLE - 1), (size.rows - 1) // (_WHOLE - 1))


def _heights(window, source, side):
    memory = gdal.Translate("", str(source), format="MEM", srcWin=[window.column, window.row, side, side])
    band = memory.GetRasterBand(1)
    gdal.FillNodata(band, band.GetMaskBand(), 1000, 0)
    return memory, band.ReadAsArray()


def raster(window, data, side):
    """The window as a file; None where the data set is missing."""
    source = Path(data) / window.file
    if not source.exists():
        return None
    return Raster(window.name, made(CACHE / f"chart_{window.name}_{side}.tif", lambda partial: _write(window, source, side, partial)))


def _write(window, source, side, path):
    memory, heights = _heights(window, source, side)
    transform, srs = memory.GetGeoTransform(), memory.GetSpatialRef()
    if window.scale != 1:
        heights = heights.astype(float) * (window.unit_m * window.scale)
        spacing = window.pixel_m * window.scale
        transform, srs = (500000, spacing, 0, 4000000, 0, -spacing), osr.SpatialReference()
        srs.ImportFromEPSG(32610)
    out = gdal.GetDriverByName("GTiff").Create(str(path), side, side, 1, gdal.GDT_Int16, options=["COMPRESS=DEFLATE"])
    out.SetGeoTransform(transform)
    out.SetSpatialRef(srs)
    out.GetRasterBand(1).WriteArray(np.rint(heights).astype(np.int16))
