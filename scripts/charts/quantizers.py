"""scripts/chart quantizers: uniform and Lloyd-Max quantisers, one a tile of 256 x 256 samples, after figures 2 to 6 of
Fowler et al. See scripts/chart --help."""
import argparse
import json
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "benchmarks"))

import numpy as np
from osgeo import gdal

import draw  # chooses how matplotlib draws
import windows
from matplotlib.image import imsave
from programs import BIN, ROOT, run, shown

plt = draw.plt
DOCS = ROOT / "docs" / "charts"
RECORDS = DOCS / "quantizers.jsonl"
PICTURED, PICTURE_BITS, PICTURE_SIDE = "california", (2, 4, 6, 8), 420
SHADED_BITS = range(2, 13)
COLORS = {"uniform": "#DDCC77", "lloyd-max": "#332288"}
LIGHT = np.array([-1.0, 1.0, 1.0]) / np.sqrt(3)  # from the north-west, 35 degrees high


def shade(heights, spacing):
    """Grey levels, 0 to 255, of the slopes under the light."""
    down, across = np.gradient(heights.astype(float), spacing)
    light = (-across * LIGHT[0] + down * LIGHT[1] + LIGHT[2]) / np.sqrt(across**2 + down**2 + 1)
    return 255 * np.clip(light, 0, 1)


def measured(window, data, folder):
    """Records of one terrain, and its heights by quantiser and rate."""
    raster = windows.raster(window, data, windows.SIDE)
    if raster is None:
        print(f"left out: {window.name}: {data / window.file} is not there", file=sys.stderr)
        return [], None
    cost = run(BIN / "bench_quantizers", raster.path, "--heights", folder)
    report = cost.json()
    source = gdal.Open(str(raster.path))
    exact = source.ReadAsArray()
    spacing = spacing_m(source)
    left = {}
    for rate in report["rates"]:
        rate |= {"data": window.name, "range_m": report["range_m"], "command": cost.command.replace(str(folder), "DIR")}
        for length in ("rms_m", "max_m", "range_m"):
            rate[length] /= window.scale
        name = rate["quantizer"], rate["bits_per_vertex"]
        if name[1] in SHADED_BITS:
            left[name] = np.fromfile(folder / f"{name[0]}_{name[1]}.f32", np.float32).reshape(exact.shape)
            rate["shade_rms"] = float(np.sqrt(np.mean((shade(left[name], spacing) - shade(exact, spacing)) ** 2)))
    return report["rates"], (exact, left, spacing)


def spacing_m(source):
    spacing = abs(source.GetGeoTransform()[1])
    srs = source.GetSpatialRef()
    return spacing * 111320 if srs is not None and srs.IsGeographic() else spacing


def lines(axes, records, field):
    for quantizer, color in COLORS.items():
        points = [(r["bits_per_vertex"], r[field]) for r in records if r["quantizer"] == quantizer and r.get(field)]
        if points:
            axes.plot(*zip(*points), color=color, marker="o", markersize=3, linewidth=1.4, label=quantizer)


def chart(records, path):
    terrains = list(dict.fromkeys(r["data"] for r in records))
    rows = (("psnr_db", "PSNR, dB", "linear"), ("max_m", "largest error, m", "log"),
            ("shade_rms", "RMS change of shading, of 255", "log"), ("design_seconds", "design, processor s", "log"))  # fmt: skip
    figure, grid = plt.subplots(len(rows), len(terrains), figsize=(3.1 * len(terrains), 2.4 * len(rows)), sharex=True, sharey="row", squeeze=False)
    for line, (field, label, scale) in zip(grid, rows):
        line[0].set_ylabel(label)
        for axes, terrain in zip(line, terrains):
            lines(axes, [r for r in records if r["data"] == terrain], field)
            axes.set_yscale(scale)
    for axes, terrain in zip(grid[0], terrains):
        axes.set_title(terrain)
    for axes in grid[-1]:
        axes.set_xlabel("bits a vertex")
    grid[0][0].legend(frameon=False)
    figure.tight_layout()
    figure.savefig(path, metadata={"Date": None})
    plt.close(figure)


def pictures(exact, left, spacing, path):
    """Rows: 2, 4, 6 and 8 bits; columns: uniform, Lloyd-Max, the DEM."""
    part = (slice(0, PICTURE_SIDE), slice(0, PICTURE_SIDE))
    frame = ((2, 2), (2, 2))
    cells = [[left["uniform", bits], left["lloyd-max", bits], exact] for bits in PICTURE_BITS]
    grey = np.vstack([np.hstack([np.pad(shade(h, spacing)[part], frame, constant_values=255) for h in row]) for row in cells])
    imsave(path, grey.astype(np.uint8), cmap="gray", vmin=0, vmax=255)


def main():
    parser = argparse.ArgumentParser(prog="scripts/chart quantizers", description=__doc__)
    parser.add_argument("--data", default=ROOT.parent / "shared" / "data", type=Path, help="folder of the DEMs")
    args = parser.parse_args()
    records = []
    with tempfile.TemporaryDirectory() as folder:
        for window in windows.WINDOWS:
            found, heights = measured(window, args.data, Path(folder))
            records += found
            if window.name == PICTURED and heights:
                pictures(*heights, DOCS / "quantizers.png")
                print(shown(DOCS / "quantizers.png"))
    if not records:
        sys.exit(f"scripts/chart: no DEM of scripts/charts/windows.py in {args.data}; name the folder that has them: --data DIR")
    RECORDS.write_text("".join(json.dumps(r) + "\n" for r in records))
    chart(records, DOCS / "quantizers.svg")
    print(shown(DOCS / "quantizers.svg"), shown(RECORDS), sep="\n")


main()
