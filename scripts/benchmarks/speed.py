"""Table 3: the whole build's time against threads and samples."""
from statistics import median

import tintree
from datasets import crop, mirrored, whole
from results import number, print_table

SIDES = (1025, 2049, 4097, 8193)
LARGE = ((2, 2), (4, 2))  # mirror images of the Moon: 16385 x 16385 and 32769 x 16385 samples


def rasters(data, quick, large):
    for side in SIDES[:2] if quick else SIDES:
        yield crop(data, "moon", side, side) if side != SIDES[-1] else whole(data, "moon")
    if not quick:
        yield whole(data, "california")
    if large:
        yield from (mirrored(data, "moon", *times) for times in LARGE)


def run(results, data, quick, large):
    for raster in rasters(data, quick, large):
        repeats = 1 if quick or raster.samples > 10**8 else 3
        for effort, options in tintree.EFFORTS.items():
            for threads in (2,) if raster.samples > 10**8 else (1, 2):
                _measure(results, raster, effort, options, threads, repeats)
        if raster in (whole(data, "moon"), whole(data, "california")):
            for name, options in tintree.METHODS.items():
                if name not in tintree.EFFORTS:
                    _measure(results, raster, name, options, threads=2, repeats=1)
    print_tables(results)


def _measure(results, raster, name, options, threads, repeats):
    options = [*options, "--threads", str(threads)]
    results.once("speed", lambda: _figures(raster, options, repeats), data=raster.name, method=f"tintree {name}",
                 threads=threads, runs=repeats)


def _figures(raster, options, repeats):
    runs = [tintree.build(raster, *options) for _ in range(repeats)]
    report = runs[0][0]
    making = [level["thread_seconds"] for level in report["levels"]]
    return {"samples": raster.samples, "seconds": median(r["seconds"] for r, _ in runs),
            "cpu_seconds": median(c.cpu_seconds for _, c in runs), "upper_share": sum(making[:-1]) / sum(making),
            "bytes": report["bytes"], "peak_rss_bytes": runs[0][1].peak_rss_bytes, "digest": report["digest"],
            "command": runs[0][1].command}


def print_tables(results):
    records = results.of("speed")
    single = {(r["data"], r["method"]): r["seconds"] for r in records if r["threads"] == 1}
    rows = []
    for r in records:
        one = single.get((r["data"], r["method"]))
        rows.append([r["data"], number(r["samples"] / 1e6), r["method"], r["threads"], number(r["seconds"], 3),
                     number(r["cpu_seconds"], 3), number(r["samples"] / r["seconds"] / 1e6, 3),
                     f"{one / r['seconds']:.2f}" if one else None, f"{100 * r['upper_share']:.0f} %", number(r["bytes"]),
                     number(8 * r["bytes"] / r["samples"], 3), r["runs"]])
    print_table("Whole builds at the default error (seconds: median of the runs)",
                ["data", "M samples", "method", "threads", "s", "CPU s", "M samples/s", "scaling", "upper levels",
                 "file bytes", "file bits a sample", "runs"], rows)
