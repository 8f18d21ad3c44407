"""Table 4: peak memory against --memory and the raster's size."""
import tintree
from datasets import mirrored, whole
from results import number, print_table
from speed import LARGE

LIMITS_MIB = (256, 1024)


def run(results, data, quick, large):
    rasters = [whole(data, "moon")] + ([mirrored(data, "moon", *times) for times in LARGE] if large else [])
    for raster in rasters:
        for effort, options in list(tintree.EFFORTS.items())[: 1 if quick else None]:
            for limit in LIMITS_MIB:
                results.once("memory", lambda o=("--memory", str(limit), *options): _figures(raster, o), data=raster.name,
                             columns=raster.size[0], rows=raster.size[1], limit_mib=limit, method=f"tintree {effort}")
    print_tables(results)


def _figures(raster, options):
    report, cost = tintree.build(raster, *options)
    return {"peak_rss_bytes": cost.peak_rss_bytes, "seconds": report["seconds"], "digest": report["digest"],
            "command": cost.command}


def print_tables(results):
    rows = []
    for r in results.of("memory"):
        peak = r["peak_rss_bytes"] / 2**20
        rows.append([f"{r['columns']} x {r['rows']}", r["method"], r["limit_mib"],
                     f"**{peak:.0f}**" if peak > r["limit_mib"] else f"{peak:.0f}", number(r["seconds"], 3), r["digest"][:8]])
    print_table("Peak resident memory", ["raster", "method", "--memory MiB", "peak MiB", "s", "digest"], rows)
