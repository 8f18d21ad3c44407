"""Builds, audits and exports DEMs of every kind that real files come in, and checks the finest mesh at every
sample, in place and height, against GDAL's own reading.

usage: raster_kinds.py BIN_DIR
The DEMs are made here. What is expected is found from the files by GDAL and numpy, in the files' own pixels.
"""
import math
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from mesh import in_surface, paint, read_ply
from osgeo import gdal, osr

gdal.UseExceptions()
gdal.PushErrorHandler("CPLQuietErrorHandler")
UTM, DEGREES, FEET = 32610, 4326, 2225
US_FOOT = 1200 / 3937
NORTH_UP = (500000, 10, 0, 4000000, 0, -10)
ERROR_M = 4


def hills(columns, rows):
    y, x = np.mgrid[0:rows, 0:columns]
    return np.round(60 + 40 * np.sin(x / 9.0) * np.cos(y / 7.0) + 9 * np.sin(x / 2.3 + y / 3.1))


def turned(degrees, spacing=10.0, shear=0.0):
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return (500000, spacing * c, spacing * (s + shear), 4000000, spacing * s, -spacing * c)


def write(path, heights, transform=NORTH_UP, epsg=UTM, kind=gdal.GDT_Float32, driver="GTiff", options=(), nodata=None):
    rows, columns = heights.shape
    raster = gdal.GetDriverByName(driver).Create(str(path), columns, rows, 1, kind, options=list(options))
    if transform:
        raster.SetGeoTransform(transform)
        crs = osr.SpatialReference()
        crs.ImportFromEPSG(epsg)
        raster.SetProjection(crs.ExportToWkt())
    band = raster.GetRasterBand(1)
    if nodata is not None:
        band.SetNoDataValue(nodata)
        heights = np.where(np.isnan(heights), nodata, heights)
    band.WriteArray(heights)
    return raster


def metres_per_unit(raster):
    crs = raster.GetSpatialRef()
    if crs is None:
        return 1.0, 1.0
    if not crs.IsGeographic():
        return crs.GetLinearUnits(), crs.GetLinearUnits()
    transform = raster.GetGeoTransform()
    latitude = math.radians(transform[3] + transform[5] * raster.RasterYSize / 2)
    a, b = crs.GetSemiMajor(), crs.GetSemiMinor()
    e2 = 1 - (b / a) ** 2
    w = math.sqrt(1 - e2 * math.sin(latitude) ** 2)
    return math.radians(a / w * math.cos(latitude)), math.radians(a * (1 - e2) / w**3)


def read_heights(raster, unit_m=1.0):
    """Metres as GDAL reads them: scale, offset, nodata and masks applied."""
    band = raster.GetRasterBand(1)
    heights = band.ReadAsArray().astype(np.float64)
    mask = band.GetMaskBand().ReadAsArray()
    scale, offset = band.GetScale() or 1.0, band.GetOffset() or 0.0
    return np.where((mask != 0) & np.isfinite(heights), (heights * scale + offset) * unit_m, np.nan)


def call(*words):
    done = subprocess.run([str(w) for w in words], capture_output=True, text=True)
    return done.returncode, done.stdout + done.stderr


class Checker:
    def __init__(self, bin_dir, folder):
        self.bin_dir, self.folder, self.count = Path(bin_dir), folder, 0

    def run(self, program, *words):
        code, text = call(self.bin_dir / f"tintree-{program}", *words, "--quiet")
        assert code == 0, f"tintree-{program} {words}: exit {code}: {text}"

    def mesh(self, paths, options=(), error_m=ERROR_M):
        """Builds and audits; returns the finest mesh and the CRS coordinates of its origin."""
        self.count += 1
        tree = self.folder / f"{self.count}.tintree"
        ply = self.folder / f"{self.count}.ply"
        self.run("build", *paths, "-o", tree, "--error", error_m, "--tile", 64, "--threads", 1, *options)
        self.run("audit", tree, "--dem", *paths, "--threads", 1, "--hausdorff-tiles", 0)
        self.run("export", tree, "--to", "ply", "--error", error_m, "-o", ply)
        text = ply.read_bytes()[:4000].decode(errors="replace")
        found = re.search(r"CRS coordinates (\S+) (\S+)", text)
        vertices, faces = read_ply(ply)
        return vertices, faces, (float(found[1]), float(found[2]))

    def check(self, name, paths, expected=None, raster=None, flip=None, unit_m=1.0, options=(), error_m=ERROR_M):
        """`expected` are the heights on `raster`'s pixels, by default what GDAL reads there. `flip` takes the
        pixels to the tree's own order of rows and columns and back; holes are cut on that grid."""
        raster = raster or gdal.Open(str(paths[0]))
        expected = read_heights(raster, unit_m) if expected is None else expected
        flip = flip or (lambda a: a)
        vertices, faces, origin = self.mesh(paths, options, error_m)
        east_m, north_m = metres_per_unit(raster)
        t = raster.GetGeoTransform()
        back = np.linalg.inv(np.array([[t[1], t[2]], [t[4], t[5]]]))
        offsets = np.stack([origin[0] + vertices[:, 0] / east_m - t[0], origin[1] + vertices[:, 1] / north_m - t[3]])
        columns, rows = back @ offsets - 0.5
        nearest = max(np.abs(columns - columns.round(3)).max(), np.abs(rows - rows.round(3)).max())
        assert nearest < 1e-3, f"{name}: vertices lie {nearest} samples off the grid's eighths"
        mesh = paint(columns.round(3), rows.round(3), vertices[:, 2], faces, expected.shape)
        surface = flip(in_surface(flip(expected)))
        assert (np.isnan(mesh) == ~surface).all(), f"{name}: the mesh does not cover the surface exactly"
        error = np.nanmax(np.abs(mesh - expected))
        print(f"{name}: {len(faces)} triangles, {error:.4f} m off at the samples")
        assert error <= error_m * (1 + 1e-9), f"{name}: {error} m off"

    def refused(self, name, paths, code, *words):
        found, text = call(self.bin_dir / "tintree-build", *paths, "-o", self.folder / "no.tintree", "--quiet")
        assert found == code, f"{name}: exit {found}, not {code}: {text}"
        assert text.count("\n") == 1 and all(word in text for word in words), f"{name}: {text}"
        print(f"{name}: {text.strip()}")


def check_types(checker, folder):
    heights = hills(70, 53)
    for kind in (gdal.GDT_Byte, gdal.GDT_UInt16, gdal.GDT_Int16, gdal.GDT_UInt32, gdal.GDT_Int32, gdal.GDT_Int64,
                 gdal.GDT_UInt64, gdal.GDT_Float32, gdal.GDT_Float64):
        name = gdal.GetDataTypeName(kind)
        path = folder / f"{name}.tif"
        write(path, np.where(hills(70, 53) > 95, np.nan, heights), kind=kind, nodata=7)
        checker.check(f"type {name}", [path])
    path = folder / "scaled.tif"
    raster = write(path, heights * 10, kind=gdal.GDT_Int16)
    raster.GetRasterBand(1).SetScale(0.1)
    raster.GetRasterBand(1).SetOffset(-40)
    raster = None
    checker.check("scale and offset", [path])
    path = folder / "feet.tif"
    raster = write(path, heights, (6000000, 5, 0, 2000000, 0, -5), FEET)
    raster.GetRasterBand(1).SetUnitType("us-ft")
    raster = None
    checker.check("feet", [path], unit_m=US_FOOT)


def check_missing(checker, folder):
    heights = hills(140, 90)
    heights[30:50, 40:70] = np.nan
    heights[(np.mgrid[0:90, 0:140][1] + np.mgrid[0:90, 0:140][0]) > 190] = np.nan  # a coast
    heights[80, 130] = 50  # islands of one sample, two and three
    heights[70, 138:140] = 50
    heights[60:62, 139] = heights[61, 138] = 50
    write(folder / "nan.tif", heights)
    checker.check("NaN", [folder / "nan.tif"])
    for kind in ("mask", "alpha"):
        path = folder / f"{kind}.tif"
        raster = gdal.GetDriverByName("GTiff").Create(str(path), 140, 90, 2 if kind == "alpha" else 1, gdal.GDT_UInt16)
        raster.SetGeoTransform(NORTH_UP)
        raster.GetRasterBand(1).WriteArray(np.nan_to_num(heights, nan=99))
        if kind == "alpha":
            raster.GetRasterBand(2).SetColorInterpretation(gdal.GCI_AlphaBand)
        else:
            raster.CreateMaskBand(gdal.GMF_PER_DATASET)
        mask = raster.GetRasterBand(2) if kind == "alpha" else raster.GetRasterBand(1).GetMaskBand()
        mask.WriteArray(np.where(np.isnan(heights), 0, 65535 if kind == "alpha" else 255))
        raster = mask = None
        checker.check(f"{kind} band", [path], expected=heights)


def check_grids(checker, folder):
    heights = hills(150, 75)
    heights[20:30, 60:75] = np.nan
    south_up = (500000, 10, 0, 4000000, 0, 10)
    mirrored = (500000, -10, 0, 4000000, 0, -10)
    both = (500000, -10, 0, 4000000, 0, 10)
    cases = [("south-up", south_up, np.flipud), ("mirrored", mirrored, np.fliplr), ("turned by 180", both, np.flip),
             ("turned by 90", turned(90), None), ("turned by -90", turned(-90), None), ("turned by 31", turned(31), None),
             ("turned by 200", turned(200), np.flip), ("sheared", turned(12, shear=0.4), None)]
    for name, transform, flip in cases:
        path = folder / (name.replace(" ", "_") + ".tif")
        write(path, heights, transform)
        checker.check(name, [path], flip=flip)
    write(folder / "degrees.tif", heights, (-122.2, 0.0003, 0, 46.3, 0, -0.0002), DEGREES)
    checker.check("degrees", [folder / "degrees.tif"])
    write(folder / "south_degrees.tif", heights, (170.2, 0.0003, 0, -46.3, 0, 0.0002), DEGREES)
    checker.check("degrees, south-up", [folder / "south_degrees.tif"], flip=np.flipud)
    for columns, rows in ((2, 2), (3, 2), (2, 129), (129, 129), (130, 130), (1000, 7), (7, 1000)):
        path = folder / f"{columns}x{rows}.tif"
        write(path, hills(columns, rows))
        checker.check(f"{columns} x {rows}", [path])
    for columns, rows in ((1, 1), (1, 40), (40, 1)):
        path = folder / f"{columns}x{rows}.tif"
        write(path, hills(columns, rows))
        checker.refused(f"{columns} x {rows}", [path], 3, f"{columns} x {rows}", "beside it")


def check_formats(checker, folder):
    heights = hills(95, 80)
    heights[10:14, 10:20] = np.nan
    source = folder / "source.tif"
    write(source, heights, kind=gdal.GDT_Int16, nodata=-32768)
    for name, options in (("COG", "-of COG"), ("AAIGrid", "-of AAIGrid"), ("netCDF", "-of netCDF"), ("ENVI", "-of ENVI"),
                          ("strips", "-co COMPRESS=DEFLATE -co BLOCKYSIZE=1"),
                          ("one strip", "-co COMPRESS=DEFLATE -co BLOCKYSIZE=80")):
        path = folder / f"{name.replace(' ', '_')}.{dict(COG='tif', AAIGrid='asc', netCDF='nc', ENVI='img').get(name, 'tif')}"
        gdal.Translate(str(path), str(source), options=options)
        checker.check(name, [path])
    pixels = folder / "pixels.mrf"
    gdal.Translate(str(pixels), str(source), options="-of MRF -co BLOCKSIZE=1 -co COMPRESS=NONE")
    assert gdal.Open(str(pixels)).GetRasterBand(1).GetBlockSize() == [1, 1]
    checker.check("blocks of one pixel", [pixels])
    png = folder / "png16.png"
    plain = gdal.GetDriverByName("MEM").Create("", 95, 80, 1, gdal.GDT_UInt16)
    plain.GetRasterBand(1).WriteArray(hills(95, 80) * 30)
    gdal.GetDriverByName("PNG").CreateCopy(str(png), plain)
    checker.check("PNG of 16 bits", [png], raster=with_unit_transform(png), error_m=90)
    smooth = np.mgrid[0:1201, 0:1201][0] // 10
    smooth[300:340, 500:600] = -32768
    step = 1 / 1200
    write(folder / "hgt.tif", smooth, (-122 - step / 2, step, 0, 47 + step / 2, 0, -step), DEGREES, gdal.GDT_Int16)
    gdal.Translate(str(folder / "N46W122.hgt"), str(folder / "hgt.tif"), options="-of SRTMHGT")
    checker.check("HGT", [folder / "N46W122.hgt"], error_m=4)
    usgs = folder / "small.dem"
    gdal.Translate(str(usgs), str(source), options="-of USGSDEM")
    checker.check("USGS DEM", [usgs])


def with_unit_transform(path):
    """The raster as it is taken where it states no georeference."""
    raster = gdal.GetDriverByName("MEM").CreateCopy("", gdal.Open(str(path)))
    raster.SetGeoTransform((0, 1, 0, 0, 0, -1))
    raster.SetProjection("")
    return raster


def window(transform, column, row):
    t = transform
    return (t[0] + column * t[1] + row * t[2], t[1], t[2], t[3] + column * t[4] + row * t[5], t[4], t[5])


def check_mosaics(checker, folder):
    heights = hills(220, 150)
    heights[40:60, 90:120] = np.nan
    corners = {"a": (0, 0, 110, 90), "b": (100, 0, 220, 80), "c": (0, 85, 130, 150), "d": (140, 85, 219, 149),
               "e": (219, 85, 220, 149)}  # overlaps, a gap, and a file of one column
    kinds = {"a": gdal.GDT_Int16, "b": gdal.GDT_Float64, "c": gdal.GDT_Float32, "d": gdal.GDT_Int32, "e": gdal.GDT_Int16}
    paths, expected = [], np.full_like(heights, np.nan)
    for i, (name, (c0, r0, c1, r1)) in enumerate(corners.items()):
        path = folder / f"mosaic_{name}.tif"
        part = heights[r0:r1, c0:c1] + 20 * i  # overlaps differ, so that their order shows
        write(path, part, window(NORTH_UP, c0, r0), kind=kinds[name], nodata=-100 - i)
        over = expected[r0:r1, c0:c1]
        over[~np.isnan(part)] = part[~np.isnan(part)]
        paths.append(path)
    grid = gdal.GetDriverByName("MEM").CreateCopy("", write(folder / "grid.tif", heights))
    checker.check("mosaic", paths, expected=expected, raster=grid)

    same = [folder / f"same_{name}.tif" for name in "ab"]
    for i, (path, name) in enumerate(zip(same, "ab")):
        c0, r0, c1, r1 = corners[name]
        write(path, heights[r0:r1, c0:c1] + 20 * i, window(NORTH_UP, c0, r0), kind=gdal.GDT_Int16, nodata=-100)
    for order in (same, same[::-1]):
        vrt = gdal.BuildVRT("", [str(p) for p in order], VRTNodata=-100)
        checker.check("mosaic like gdalbuildvrt", order, raster=vrt)

    south = folder / "south.tif"
    c0, r0, c1, r1 = corners["c"]
    t = window(NORTH_UP, c0, r1)
    write(south, np.flipud(heights[r0:r1, c0:c1] + 40), t[:5] + (10,), nodata=-1)
    checker.check("mosaic with a south-up file", [*paths[:2], south, *paths[3:]], expected=expected, raster=grid)

    slanted = turned(25)
    for name in "ab":
        c0, r0, c1, r1 = corners[name]
        write(folder / f"slanted_{name}.tif", heights[r0:r1, c0:c1], window(slanted, c0, r0))
    both = np.full((90, 220), np.nan)
    both[:90, :110] = heights[:90, :110]
    both[:80, 100:] = np.where(np.isnan(heights[:80, 100:]), both[:80, 100:], heights[:80, 100:])
    checker.check("mosaic of turned files", [folder / "slanted_a.tif", folder / "slanted_b.tif"], expected=both,
                  raster=gdal.GetDriverByName("MEM").CreateCopy("", write(folder / "slanted.tif", both, slanted)))

    write(folder / "zone.tif", heights, epsg=32611)
    write(folder / "coarse.tif", heights, (500000, 20, 0, 4000000, 0, -20))
    write(folder / "half.tif", heights, (500005, 10, 0, 4000000, 0, -10))
    write(folder / "plain.tif", heights, None)
    for name, words in (("zone", ("reference system", "gdalwarp")), ("coarse", ("2 times as far apart", "gdalwarp")),
                        ("half", ("samples off", "gdalwarp")), ("slanted_a", ("samples off",)),
                        ("plain", ("georeference", "gdal_edit"))):
        checker.refused(f"mosaic with {name}", [paths[0], folder / f"{name}.tif"], 3, f"{name}.tif", "mosaic_a.tif", *words)


def check_fill(checker, folder):
    for kind in (gdal.GDT_Float32, gdal.GDT_Float64):
        heights = hills(300, 280) + (0.1 if kind == gdal.GDT_Float64 else 0)
        heights[40:60, 50:70] = np.nan
        heights[100:105, :] = np.nan
        heights[150:, 140:] = np.nan  # the far corner lies beyond the fill's reach
        path = folder / f"holes_{kind}.tif"
        write(path, heights, kind=kind, nodata=-5)
        filled = gdal.GetDriverByName("MEM").CreateCopy("", write(folder / "work.tif", heights, nodata=-5))
        gdal.FillNodata(filled.GetRasterBand(1), None, 100, 0)
        expected = np.where(np.isnan(heights), read_heights(filled), heights)
        assert 0 < np.isnan(expected).sum() < np.isnan(heights).sum() / 2
        checker.check(f"filled, {gdal.GetDataTypeName(kind)}", [path], expected=expected, options=["--nodata", "fill"])
    checker.check("not filled", [path], options=["--nodata", "hole"])
    left = [p.name for p in folder.iterdir() if p.name.startswith("tintree-")]
    assert not left, f"left behind: {left}"


def main():
    with tempfile.TemporaryDirectory() as folder:
        checker = Checker(sys.argv[1], Path(folder))
        for check in (check_types, check_missing, check_grids, check_formats, check_mosaics, check_fill):
            check(checker, Path(folder))


main()
