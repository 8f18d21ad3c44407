"""scripts/chart: speed, bytes and memory against measured error. See scripts/chart --help."""
import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "benchmarks"))

import draw
import exclusive
import page
import windows
from memo import Memo, read_lines
from panels import CHARTS
from programs import BENCH, ROOT, shown
from record import merged, write
from sweep import Sweep, tasks

DOCS = ROOT / "docs" / "charts"
OWN = BENCH / "charts"


def arguments():
    parser = argparse.ArgumentParser(prog="scripts/chart", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="small windows, few errors, no slow rivals")
    parser.add_argument("--only", choices=list(CHARTS), action="append", help="this chart; may be given again")
    parser.add_argument("--draw-only", action="store_true", help="measure nothing")
    parser.add_argument("--data", default=ROOT.parent / "shared" / "data", type=Path, help="folder of the DEMs")
    return parser.parse_args()


def measured(args, charts):
    side = windows.QUICK_SIDE if args.quick else windows.SIDE
    rasters = {window: windows.raster(window, args.data, side) for window in windows.WINDOWS}
    for window in [w for w, raster in rasters.items() if raster is None]:
        print(f"left out: {window.name}: {args.data / window.file} is not there", file=sys.stderr)
        del rasters[window]
    if not rasters:
        sys.exit(f"scripts/chart: no DEM of scripts/charts/windows.py in {args.data}; name the folder that has them: --data DIR")
    kinds = {panel.kind for chart in charts for panel in chart.panels}
    if "size" in kinds:
        sizes = windows.QUICK_SIZES if args.quick else windows.SIZES
        rasters |= {size: raster for size in sizes if (raster := windows.size_raster(size, args.data))}
    sweep = Sweep(rasters, Memo(OWN / "cache.jsonl"))
    sweep.run(tasks(list(rasters), kinds, args.quick))
    return sweep


def main():
    args = arguments()
    OWN.mkdir(parents=True, exist_ok=True)
    lock = exclusive.keep_others_out("scripts/chart")
    into = OWN / "quick" if args.quick else DOCS
    results = into / "results.jsonl"
    charts = [CHARTS[name] for name in args.only or CHARTS]
    failed = []
    records = read_lines(results)
    if not args.draw_only:
        sweep = measured(args, charts)
        failed = sweep.failed
        records = write(results, merged(records, sweep.done))
    if not records:
        sys.exit(f"scripts/chart: {shown(results)} has no figures to draw; run without --draw-only")
    for path in draw.charts(charts, records, into):
        print(shown(path))
    print(shown(page.write(into, records)))
    for failure in failed:
        print(f"scripts/chart: failed: {failure}", file=sys.stderr)
    lock.close()
    sys.exit(1 if failed else 0)


try:
    main()
except KeyboardInterrupt:
    print("\nscripts/chart: stopped; the same command goes on from here", file=sys.stderr)
    sys.exit(5)
