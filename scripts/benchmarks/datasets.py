"""The elevation models that are measured on, their windows, and how to make larger ones of them."""
import math
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from osgeo import gdal

from programs import CACHE

gdal.UseExceptions()

DEMS = {"moon": "moon_8193.tif", "california": "calif_13201x4801.tif"}
#: A square without holes in each, 1025 samples a side: north-west corner. California's is the Sierra Nevada.
CROPS = {"moon": (0, 0), "california": (6000, 1000)}
CROP_SIDE = 1025


@dataclass(frozen=True)
class Raster:
    name: str
    path: Path

    @cached_property
    def size(self):
        dem = gdal.Open(str(self.path))
        return dem.RasterXSize, dem.RasterYSize

    @property
    def samples(self):
        return self.size[0] * self.size[1]

    @cached_property
    def spacing_m(self):
        """dx and dy in metres, by the definition in docs/accuracy.md."""
        dem = gdal.Open(str(self.path))
        _, dx, _, north, _, dy = dem.GetGeoTransform()
        srs = dem.GetSpatialRef()
        if not srs.IsGeographic():
            return abs(dx) * srs.GetLinearUnits(), abs(dy) * srs.GetLinearUnits()
        phi = math.radians(north + dy * dem.RasterYSize / 2)
        a, flattening = srs.GetSemiMajor(), 1 / srs.GetInvFlattening()
        e2 = flattening * (2 - flattening)
        w = 1 - e2 * math.sin(phi) ** 2
        meridian, normal = a * (1 - e2) / w**1.5, a / math.sqrt(w)
        return math.radians(abs(dx)) * normal * math.cos(phi), math.radians(abs(dy)) * meridian

    @property
    def mean_spacing_m(self):
        return math.sqrt(math.prod(self.spacing_m))

    def heights(self):
        """Samples and where they are valid; the others are 0."""
        dem = gdal.Open(str(self.path))
        heights, nodata = dem.ReadAsArray(), dem.GetRasterBand(1).GetNoDataValue()
        valid = heights != nodata if nodata is not None else np.ones(heights.shape, bool)
        return np.where(valid, heights, 0), valid


def made(path, make):
    """`path`, and that make(partial path) has made it: a run that is stopped leaves no half of a file behind."""
    if not path.exists():
        path.parent.mkdir(parents=True, exist_ok=True)
        partial = path.with_name(f"partial_{path.name}")
        make(partial)
        partial.rename(path)
    return path


def cut(path, source, window):
    """A window (column, row, columns, rows) of a raster as a file of its own."""
    return made(path, lambda partial: gdal.Translate(str(partial), str(source), srcWin=list(window)))


def whole(data, name):
    return Raster(name, Path(data) / DEMS[name])


def crop(data, name, columns=CROP_SIDE, rows=CROP_SIDE):
    """A window of a DEM as a file of its own."""
    column0, row0 = CROPS[name] if columns == CROP_SIDE else (0, 0)
    path = CACHE / f"{name}_{columns}x{rows}.tif"
    cut(path, Path(data) / DEMS[name], (column0, row0, columns, rows))
    return Raster(f"{name} {columns}²" if columns == rows else f"{name} {columns}x{rows}", path)


def raw_heights(raster):
    """The samples as 64-bit floats, NaN for none, for the programs that take an array."""

    def write(partial):
        heights, valid = raster.heights()
        np.where(valid, heights.astype(np.float64), np.nan).tofile(partial)

    return made(CACHE / f"{raster.path.stem}.f64", write)


def _flipped_copies(source):
    """The DEM as it is and mirrored in x, y and both: {(x, y): path}."""
    copies = {(0, 0): source.path.resolve()}

    def write(partial, flip):
        heights = gdal.Open(str(source.path)).ReadAsArray()[:: -1 if flip[1] else 1, :: -1 if flip[0] else 1]
        options = ["TILED=YES", "COMPRESS=DEFLATE", "PREDICTOR=2"]
        driver = gdal.GetDriverByName("GTiff")
        copy = driver.Create(str(partial), heights.shape[1], heights.shape[0], 1, gdal.GDT_Int16, options)
        copy.GetRasterBand(1).WriteArray(heights)

    for flip in ((1, 0), (0, 1), (1, 1)):
        path = CACHE / f"{source.name}_flipped_{flip[0]}{flip[1]}.tif"
        copies[flip] = made(path, lambda partial, flip=flip: write(partial, flip))
    return copies


def mirrored(data, name, times_x, times_y):
    """A DEM continued by its mirror images, which share the samples on the seams: a raster of any size."""
    source = whole(data, name)
    columns, rows = source.size
    wide, high = times_x * (columns - 1) + 1, times_y * (rows - 1) + 1
    path = CACHE / f"{name}_{wide}x{high}.vrt"
    copies = _flipped_copies(source)
    dem = gdal.Open(str(source.path))
    parts = "".join(
        f'<SimpleSource><SourceFilename relativeToVRT="0">{copies[i % 2, j % 2]}</SourceFilename>'
        f'<SourceBand>1</SourceBand><SrcRect xOff="0" yOff="0" xSize="{columns}" ySize="{rows}"/>'
        f'<DstRect xOff="{i * (columns - 1)}" yOff="{j * (rows - 1)}" xSize="{columns}" ySize="{rows}"/></SimpleSource>'
        for j in range(times_y)
        for i in range(times_x)
    )
    transform = ", ".join(map(repr, dem.GetGeoTransform()))
    srs = dem.GetSpatialRef().ExportToWkt().replace('"', "&quot;")
    path.write_text(
        f'<VRTDataset rasterXSize="{wide}" rasterYSize="{high}"><SRS>{srs}</SRS><GeoTransform>{transform}</GeoTransform>'
        f'<VRTRasterBand dataType="Int16" band="1"><NoDataValue>-32768</NoDataValue>{parts}</VRTRasterBand></VRTDataset>'
    )
    return Raster(f"{name} {wide}x{high}", path)
