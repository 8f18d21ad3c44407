"""scripts/bench wavelet: tables 1 to 5 of Yusov & Turlapov 2008 in form, on our data, and the grid coder of method
wavelet against plain JPEG 2000 under a search for the rate and against LERC. See scripts/bench --help."""
import argparse
import platform
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from osgeo import gdal

import exclusive
from programs import BIN, CACHE, ROOT, cpu_name, run
from raster_coders import jpeg2000, lerc
from results import PATH, Results, number, print_table

gdal.UseExceptions()

SIDE = 1024  # a power of two, as the paper has it
#: File, north-west sample of the window, metres a unit of height.
SITES = {"moon": ("moon_8193.tif", (0, 0), 1), "california": ("calif_13201x4801.tif", (6000, 1000), 1),
         "puget 1k": ("ps_height_1k.png", (0, 0), 0.1)}  # fmt: skip
#: Rows of the tables: name, criterion as bench_wavelet takes it, metres, samples a patch.
CRITERIA = (("max 1 m", "max", 1, 256), ("max 3 m", "max", 3, 256), ("rms 3 m", "rms", 3, 128), ("lossless residuals", "lossless", 1, 256))
BOUNDS_M = (1, 3, 16)
RAW_BITS = 16


@dataclass(frozen=True)
class Window:
    name: str
    data: Path

    @property
    def size(self):
        return SIDE, SIDE

    @property
    def samples(self):
        return SIDE * SIDE

    @property
    def unit_m(self):
        return SITES[self.name][2]

    @cached_property
    def metres(self):
        file, corner, unit_m = SITES[self.name]
        return gdal.Open(str(self.data / file)).ReadAsArray(*corner, SIDE, SIDE).astype(np.float64) * unit_m

    def heights(self):
        return self.metres, np.ones(self.metres.shape, bool)

    @cached_property
    def raw(self):
        path = CACHE / f"wavelet_{self.name.replace(' ', '_')}.f64"
        self.metres.tofile(path)
        return path


def code(window, mode, bound_m, patch, *options):
    cost = run(BIN / "bench_wavelet", window.raw, SIDE, SIDE, patch, bound_m, window.unit_m, mode, *options)
    return {**cost.json(), "command": cost.command}


def measure(results, data, quick):
    for window in (Window(name, data) for name in SITES):
        for name, mode, bound_m, patch in CRITERIA:
            for way in ("progressive",) if mode == "lossless" else ("progressive", "direct"):
                options = ("direct",) if way == "direct" else ()
                results.add("tables", data=window.name, criterion=name, way=way, **code(window, mode, bound_m, patch, *options))
        for bound_m in BOUNDS_M[: 1 if quick else None]:
            results.add("rivals", data=window.name, bound_m=bound_m, coder="as the paper", **code(window, "max", bound_m, 256))
            results.add("rivals", data=window.name, bound_m=bound_m, coder="lifted", **code(window, "lifted", bound_m, 256))
            # One patch over the whole window, foretold from nothing: plain JPEG 2000 with the search that patches have.
            results.add("rivals", data=window.name, bound_m=bound_m, coder="JPEG 2000 5/3",
                        **code(window, "max", bound_m, SIDE, "direct"))
            for name, coder in (("JPEG 2000 9/7", jpeg2000), ("LERC_ZSTD", lerc)):
                figures = coder(window, bound_m)
                figures.pop("map")
                results.add("rivals", data=window.name, bound_m=bound_m, coder=name, **figures)


def ratio(record):
    return SIDE * SIDE * RAW_BITS / 8 / record["bytes"]


def print_tables(results):
    rows = []
    for r in results.of("tables"):
        bits = "8" if r["way"] == "progressive" else "12"
        rows.append([r["data"], r["criterion"], r["way"], bits, f"{ratio(r):.2f}", number(r["samples_max_m"]),
                     number(r["rms_m"], 3), f"{r['psnr_db']:.1f}", f"{r['encodes'] / r['patches']:.1f}"])  # fmt: skip
    print_table("Tables 1 to 5: ratio to 16 bits a sample, all layers counted",
                ["data", "criterion", "way", "bits at least", "ratio", "max m", "RMS m", "PSNR dB", "encodes a patch"], rows)
    records = {(r["data"], r["bound_m"], r["coder"]): r["bytes"] for r in results.of("rivals")}
    coders = ("as the paper", "lifted", "JPEG 2000 5/3", "JPEG 2000 9/7", "LERC_ZSTD")
    rows = []
    for data, bound_m in dict.fromkeys((data, bound_m) for data, bound_m, _ in records):
        paper, ours, *plain, lerc_bytes = (records[data, bound_m, c] for c in coders)
        rows.append([data, bound_m, *(number(n) for n in (paper, ours, *plain, lerc_bytes)),
                     f"{min(plain) / ours:.2f}", f"{lerc_bytes / ours:.2f}"])  # fmt: skip
    print_table("Bytes at equal largest error",
                ["data", "max m", *coders, "gain on the smaller JPEG 2000", "on LERC"], rows)


def main():
    parser = argparse.ArgumentParser(prog="scripts/bench wavelet", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="one bound against the rivals")
    parser.add_argument("--data", default=ROOT.parent / "shared" / "data", type=Path, help="folder of the DEMs")
    parser.add_argument("--show", metavar="RUN", help="measure nothing; print the tables of an earlier run")
    args = parser.parse_args()
    results = Results(args.show)
    if not args.show:
        lock = exclusive.begin(args.data)  # held until the end
        print(f"## scripts/bench wavelet, {results.run}, {cpu_name()}, {platform.system()} {platform.machine()}")
        measure(results, args.data, args.quick)
    print_tables(results)
    print(f"\nEvery figure with the command that made it: {PATH.relative_to(ROOT)}, run {results.run}")


if __name__ == "__main__":
    main()
