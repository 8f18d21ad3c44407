"""scripts/bench scene: triangles drawn on a flight, beside the most and the fewest that would do. See scripts/bench --help."""
import argparse
import json
import math
import sys
from dataclasses import dataclass
from pathlib import Path
from statistics import median

import exclusive
from datasets import Raster, cut
from memo import digest
from programs import BIN, CACHE, ROOT, run
from results import Results, number, print_table

LADDER_TILE = 1024
RUNGS = 8  # at least; a factor of the square root of two apart

#: The trees that are drawn.
TREES = {
    "tintree fast": ("--effort", "fast"),
    "tintree best": ("--effort", "best"),
    "tintree best, tiles of 128": ("--effort", "best", "--tile", "128"),
    "tintree fast, steps of √2": ("--effort", "fast", "--levels-per-doubling", "2"),
    "tintree best, steps of √2": ("--effort", "best", "--levels-per-doubling", "2"),
    "tintree best, tiles of 128, steps of √2": ("--effort", "best", "--tile", "128", "--levels-per-doubling", "2"),
}

#: What each step from the drawn triangles to the fewest leaves out; see tests/bench/scene/scene_counts.h.
STEPS = {
    "in_picture": "parts of tiles outside the picture",
    "one_tile": "tiles: borders, and effort",
    "any_error": "levels: errors in steps",
    "fewest": "a tile taken at the place where errors show most",
}


@dataclass(frozen=True)
class Flight:
    file: str
    column: int
    row: int
    columns: int
    rows: int


FLIGHTS = {
    "moon": Flight("moon_8193.tif", 0, 0, 4097, 4097),
    "california": Flight("calif_13201x4801.tif", 5000, 200, 4097, 4097),
    "autzen": Flight("autzen_dsm_2ft_raw.tif", 0, 0, 1715, 2329),
}
QUICK_SIDE = 2049


def raster_of(name, data, quick):
    flight = FLIGHTS[name]
    columns, rows = (min(QUICK_SIDE, side) if quick else side for side in (flight.columns, flight.rows))
    path = cut(CACHE / f"scene_{name}_{columns}x{rows}.tif", Path(data) / flight.file, (flight.column, flight.row, columns, rows))
    return Raster(f"{name} {columns} x {rows}", path)


def tree_of(raster, error_m, *options):
    """A tree that stays for later runs of the same tintree-build."""
    version = digest(BIN / "tintree-build", raster.path, options, repr(error_m))
    path = CACHE / f"{raster.path.stem}_{version}.tintree"
    if not path.exists():
        print(f"  making {path.name}: error {number(error_m)} m {' '.join(options)}", file=sys.stderr, flush=True)
        run(BIN / "tintree-build", raster.path, "-o", path, "--error", repr(error_m), "--quiet", "--overwrite", *options)
    return path


def ladder_errors(leaf_error_m, levels):
    """Errors of the trees whose `levels` levels together are the rungs."""
    errors = []
    for rung in range(RUNGS):
        if rung % (2 * levels) < 2:
            errors.append(leaf_error_m * math.sqrt(2) ** rung)
    return errors


def levels_of(raster):
    cells = max(raster.size) - 1
    return max(1, math.ceil(math.log2(cells / LADDER_TILE)) + 1)


def ladder(raster, leaf_error_m):
    options = ("--tile", str(LADDER_TILE), "--effort", "best")
    return [tree_of(raster, error_m, *options) for error_m in ladder_errors(leaf_error_m, levels_of(raster))]


def fly(results, name, data, views, quick):
    raster = raster_of(name, data, quick)
    leaf_error_m = 0.5 * raster.mean_spacing_m  # tintree-build's default
    rungs = ladder(raster, leaf_error_m)
    for method, options in TREES.items():
        tree = tree_of(raster, leaf_error_m, *options)
        cost = run(BIN / "bench_scene", tree, "--views", views, "--ladder", *rungs)
        for line in cost.output.splitlines():
            results.add("scene", data=raster.name, method=method, error_m=leaf_error_m, command=cost.command, **json.loads(line))


def factors(records, above, below):
    """Of every view that shows any ground."""
    return [r[above] / r[below] for r in records if r[below] > 0]


def spread(values, digits=3):
    return [number(median(values), digits), number(max(values), digits)]


def print_tables(results):
    records = results.of("scene")
    groups = {key: [r for r in records if (r["data"], r["method"]) == key] for key in dict.fromkeys((r["data"], r["method"]) for r in records)}
    rows = [[data, method, len(rs), number(median(r["tiles"] for r in rs), 3), number(median(r["drawn"] for r in rs)),
             *spread(factors(rs, "full", "drawn")), *spread(factors(rs, "drawn", "fewest_level")), *spread(factors(rs, "drawn", "fewest")),
             number(max(r["max_error_px"] for r in rs), 3), f"{100 * max(r['beyond_ladder'] for r in rs):.0f} %"] for (data, method), rs in groups.items()]
    print_table("Triangles drawn at one pixel, against all that are in view and against the fewest that would do",
                ["data", "tree", "views", "tiles, median", "triangles drawn, median", "full / drawn, median", "highest",
                 "drawn / fewest by depth, median", "highest", "drawn / fewest, median", "highest", "largest error px", "extrapolated"], rows)
    names = ["drawn", *STEPS]
    rows = [[data, method, *(number(median(factors(rs, a, b)), 3) for a, b in zip(names, names[1:]))] for (data, method), rs in groups.items()]
    print_table("Factor that each thing costs (median of the views)", ["data", "tree", *STEPS.values()], rows)


def arguments():
    parser = argparse.ArgumentParser(prog="scripts/bench scene", description=__doc__)
    parser.add_argument("--quick", action="store_true", help=f"windows of {QUICK_SIDE} samples")
    parser.add_argument("--only", choices=FLIGHTS, action="append", help="this flight; may be given again")
    parser.add_argument("--views", type=int, default=24, help="views of a flight")
    parser.add_argument("--data", default=ROOT.parent / "shared" / "data", type=Path, help="folder of the DEMs")
    parser.add_argument("--show", metavar="RUN", help="measure nothing; print the tables of an earlier run")
    return parser.parse_args()


def main():
    args = arguments()
    results = Results(args.show)
    if not args.show:
        lock = exclusive.begin(args.data)  # held until the end
        for name in args.only or FLIGHTS:
            fly(results, name, args.data, args.views, args.quick)
    print_tables(results)
    print(f"\nRun {results.run}")


if __name__ == "__main__":
    main()
