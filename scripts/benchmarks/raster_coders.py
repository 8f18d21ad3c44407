"""Coders of the raster itself, one level, at a largest error. A coder is a row of RASTER_CODERS.

Samples without data are coded as 0 and not measured."""
import math
import time

import numpy as np
from osgeo import gdal

from fitting import largest_within
from rivals import bench_rivals

OUTPUT = "/vsimem/coded"


def _code(raster, driver, options):
    """Bytes, error and processor seconds of GDAL's driver."""
    heights, valid = raster.heights()
    memory = gdal.GetDriverByName("MEM").Create("", heights.shape[1], heights.shape[0], 1, gdal.GDT_Int16)
    memory.GetRasterBand(1).WriteArray(heights)
    before = time.process_time()
    gdal.GetDriverByName(driver).CreateCopy(OUTPUT, memory, options=options)
    seconds = time.process_time() - before
    decode_seconds = []
    for _ in range(3):
        before = time.process_time()
        decoded = gdal.Open(OUTPUT).ReadAsArray()
        decode_seconds.append(time.process_time() - before)
    distance = np.abs(decoded.astype(np.int32) - heights)[valid]
    figures = {
        "bytes": gdal.VSIStatL(OUTPUT).size,
        "samples_max_m": float(distance.max()),
        "rms_m": math.sqrt(np.mean(np.square(distance, dtype=np.float64))),
        "seconds": seconds,
        "decode_seconds": min(decode_seconds),
        "command": f"GDAL {driver} " + " ".join(options),
    }
    gdal.Unlink(OUTPUT)
    return figures


def _block(side):
    """Blocks of about 2048 without a sliver at the end."""
    return math.ceil(side / math.ceil(side / 2100))


def jpeg2000(raster, error_m):
    """The 9/7 wavelet, with a search for the rate (in percent of the raw bytes)."""
    columns, rows = raster.size
    fixed = ["CODEC=J2K", "REVERSIBLE=NO", f"BLOCKXSIZE={_block(columns)}", f"BLOCKYSIZE={_block(rows)}"]

    def make(inverse_rate):
        return _code(raster, "JP2OpenJPEG", [*fixed, f"QUALITY={100 / inverse_rate:.6g}"])

    return largest_within(make, error_m, start=16, low=2, high=4000, steps=8)


def lerc(raster, error_m):
    options = ["COMPRESS=LERC_ZSTD", f"MAX_Z_ERROR={math.floor(error_m)}", "ZSTD_LEVEL=22", "BLOCKYSIZE=256"]
    return _code(raster, "GTiff", options)


def jpegls(raster, error_m):
    cost = bench_rivals(raster, "jpegls", math.floor(error_m))
    return {**cost.json(), "command": cost.command}


RASTER_CODERS = {"JPEG-LS": jpegls, "JPEG 2000": jpeg2000, "LERC_ZSTD": lerc}


def code(name, raster, error_m):
    """One row. The decoded raster's surface errs most at its samples."""
    figures = RASTER_CODERS[name](raster, error_m)
    if figures is None:
        raise RuntimeError(f"{name} found no rate within {error_m} m")
    return {**figures, "surface_max_m": figures["samples_max_m"]}
