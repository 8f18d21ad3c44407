"""The recorded paths of scripts/bench view, as --flight files: places as shares of the raster, heights over its ground."""
import json
import math

from osgeo import gdal

from programs import CACHE

KMH = 1 / 3.6
UNITS_M = {"": 1.0, "ft": 0.3048}  # of heights, as GDAL names them


def _ground(raster):
    """Greatest height within a window of samples round a place: (column share, row share, samples) -> metres."""
    dem = gdal.Open(str(raster.path))
    columns, rows = raster.size
    band = dem.GetRasterBand(1)
    nodata, unit_m = band.GetNoDataValue(), UNITS_M[band.GetUnitType()]

    def highest(u, v, reach):
        c0, r0 = (max(0, min(n - 1, round(share * (n - 1))) - reach) for share, n in ((u, columns), (v, rows)))
        window = dem.ReadAsArray(c0, r0, min(2 * reach + 1, columns - c0), min(2 * reach + 1, rows - r0))
        valid = window[window != nodata]
        return unit_m * float(valid.max()) if valid.size else 0.0

    return highest


def _write(raster, name, keyframes):
    path = CACHE / f"flight_{name}.json"
    path.write_text(json.dumps({"fov_y_deg": 45, "keyframes": keyframes}, indent=1))
    return path


def fly(raster, name, begin, end, speed_kmh, over_m, seconds, elevation_deg, sway=0.0, reach=8):
    """A path from `begin` towards `end` (shares of the raster) at a speed, `over_m` above the ground near each keyframe."""
    highest = _ground(raster)
    dx, dy = raster.spacing_m
    wide, high = (raster.size[0] - 1) * dx, (raster.size[1] - 1) * dy
    along = ((end[0] - begin[0]) * wide, (begin[1] - end[1]) * high)
    length = math.hypot(*along)
    steps = max(4, round(seconds / 2))
    travelled = min(length, speed_kmh * KMH * seconds)
    azimuth = math.degrees(math.atan2(*along))
    keyframes = []
    for i in range(steps + 1):
        share = i / steps * travelled / length
        aside = sway * math.sin(2 * math.pi * 2 * i / steps)
        x = begin[0] * wide + along[0] * share + aside * along[1]
        y = -begin[1] * high + along[1] * share - aside * along[0]
        ground = highest(x / wide, -y / high, reach)
        keyframes.append({"seconds": seconds * i / steps, "eye_m": [x, y, ground + over_m],
                          "azimuth_deg": azimuth + 25 * math.cos(2 * math.pi * 2 * i / steps) * (sway > 0),
                          "elevation_deg": elevation_deg})
    return _write(raster, name, keyframes)


def look_into_corner(raster):
    """Stands still: the north-west corner from inside the first 1025 samples, so that every crop shows the same."""
    highest = _ground(raster)
    dx, dy = raster.spacing_m
    eye = [900 * dx, -900 * dy, highest(0, 0, 1024) + 100 * dx]
    key = {"eye_m": eye, "target_m": [450 * dx, -450 * dy, highest(0, 0, 1024) / 2]}
    return _write(raster, "corner", [{"seconds": 0, **key}, {"seconds": 2, **key}])
