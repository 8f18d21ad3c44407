"""Coders of the raster itself, one level, at a largest error. A coder is a row of RASTER_CODERS.

Samples without data are coded as 0 and not measured. Heights that are not whole metres are coded in steps of an
eighth of the error, or the largest share that 16 bits have room for; but for LERC, which takes them as they are."""
import math
import time
from dataclasses import dataclass

import numpy as np
from osgeo import gdal

from fitting import largest_within
from programs import CACHE, Failed
from rivals import bench_rivals

OUTPUT = "/vsimem/coded"
#: Steps of height an error; the last leaves rounding no more than the error.
STEPS_AN_ERROR = (8, 2, 1, 0.501)
RANGE = 2**16
SMALL_SAMPLES = 10**7  # decoding fewer is timed three times, the least counts


@dataclass(frozen=True)
class Lattice:
    """Heights in whole steps above a base: step 1 m and base 0 where they are whole metres."""

    numbers: np.ndarray
    step_m: float
    base_m: float

    @property
    def whole(self):
        return self.step_m == 1 and self.base_m == 0

    def spare_steps(self, error_m):
        """How many steps a number may be off."""
        return math.floor(error_m if self.whole else error_m / self.step_m - 0.5)


def whole_metres(heights):
    return np.array_equal(heights, np.rint(heights)) and np.abs(heights).max(initial=0) < RANGE // 2


def lattice(heights, error_m):
    """Raises Failed where 16 bits hold no lattice that is fine enough."""
    if whole_metres(heights):
        return Lattice(heights.astype(np.int64), 1.0, 0.0)
    base = float(heights.min())
    for steps in STEPS_AN_ERROR:
        if np.ptp(heights) * steps / error_m < RANGE - 1:
            return Lattice(np.rint((heights - base) * (steps / error_m)).astype(np.int64), error_m / steps, base)
    raise Failed("refused", "16 bits cannot hold heights so far apart within the error", "lattice")


def _code(raster, numbers, kind, step_m, base_m, driver, options):
    """Bytes, error and processor seconds of GDAL's driver."""
    heights, valid = raster.heights()
    memory = gdal.GetDriverByName("MEM").Create("", heights.shape[1], heights.shape[0], 1, kind)
    memory.GetRasterBand(1).WriteArray(numbers)
    before = time.process_time()
    gdal.GetDriverByName(driver).CreateCopy(OUTPUT, memory, options=options)
    seconds = time.process_time() - before
    decode_seconds = []
    for _ in range(3 if raster.samples < SMALL_SAMPLES else 1):
        before = time.process_time()
        coded = gdal.Open(OUTPUT).ReadAsArray()
        decode_seconds.append(time.process_time() - before)
    decoded = coded.astype(np.float64) * step_m + base_m
    distance = np.where(valid, np.abs(decoded - heights), np.nan)
    figures = {
        "bytes": gdal.VSIStatL(OUTPUT).size,
        "samples_max_m": float(np.nanmax(distance)),
        "rms_m": math.sqrt(np.nanmean(np.square(distance))),
        "seconds": seconds,
        "decode_seconds": min(decode_seconds),
        "command": f"GDAL {driver} " + " ".join(options),
        "map": distance,
    }
    gdal.Unlink(OUTPUT)
    return figures


def _block(side):
    """Blocks of about 2048 without a sliver at the end; the driver takes none under 32."""
    return max(32, math.ceil(side / math.ceil(side / 2100)))


def jpeg2000(raster, error_m, key="samples_max_m"):
    """The 9/7 wavelet, with a search for the rate (in percent of the raw bytes); 5/3 without loss where none will do."""
    columns, rows = raster.size
    fixed = ["CODEC=J2K", f"BLOCKXSIZE={_block(columns)}", f"BLOCKYSIZE={_block(rows)}"]
    steps = lattice(raster.heights()[0], error_m)
    kind = gdal.GDT_Int16 if steps.whole else gdal.GDT_UInt16

    def make(inverse_rate, reversible="NO"):
        options = [*fixed, f"REVERSIBLE={reversible}", f"QUALITY={100 / inverse_rate:.6g}"]
        return _code(raster, steps.numbers, kind, steps.step_m, steps.base_m, "JP2OpenJPEG", options)

    return largest_within(make, error_m, start=16, low=1, high=4000, steps=8, key=key) or make(1, "YES")


def jpeg2000_rms(raster, error_m):
    """Asked for a root mean square of half the error, as a quality in decibels is."""
    return jpeg2000(raster, error_m / 2, key="rms_m")


def lerc(raster, error_m):
    heights, _ = raster.heights()
    whole = whole_metres(heights)
    largest = math.floor(error_m) if whole else repr(error_m)
    options = ["COMPRESS=LERC_ZSTD", f"MAX_Z_ERROR={largest}", "ZSTD_LEVEL=22", "BLOCKYSIZE=256"]
    return _code(raster, heights, gdal.GDT_Int16 if whole else gdal.GDT_Float64, 1, 0, "GTiff", options)


def jpegls(raster, error_m):
    steps = lattice(raster.heights()[0], error_m)
    numbers = CACHE / "lattice.f64"
    steps.numbers.astype(np.float64).tofile(numbers)
    cost = bench_rivals(raster, "jpegls", steps.spare_steps(error_m), grid=numbers)
    figures = cost.json()
    # Rounding to steps comes on top.
    rounding = 0 if steps.whole else steps.step_m / 2
    return {**figures, "samples_max_m": figures["samples_max_m"] * steps.step_m + rounding,
            "rms_m": figures["rms_m"] * steps.step_m, "command": cost.command}


RASTER_CODERS = {"JPEG-LS": jpegls, "JPEG 2000": jpeg2000, "LERC_ZSTD": lerc}


def coded(coder, raster, error_m):
    """One row, and the error of each sample where the coder says it. The decoded raster's surface errs most at its samples."""
    figures = coder(raster, error_m)
    error_map = figures.pop("map", None)
    return {**figures, "surface_max_m": figures["samples_max_m"]}, error_map


def code(name, raster, error_m):
    return coded(RASTER_CODERS[name], raster, error_m)[0]
