"""Table 1: triangles and bytes at the same error, on one window of each DEM."""
import math

import tintree
from datasets import CROPS, crop, whole
from fitting import largest_within
from raster_coders import RASTER_CODERS, code
from results import number, print_table
from rivals import MESH_RIVALS, measure, simplify

#: Ours, by how the window is cut.
CUTS = {"one tile": ["--tile", "1024"], "default tiles": []}
ERRORS = (0.1, 0.2, 0.5, 1)  # sample spacings
QUICK_ERRORS = (0.5, 1)
SLOW_RIVALS_ERROR = 0.5  # minutes each


def run(results, data, quick):
    for name in CROPS:
        spacing = whole(data, name).mean_spacing_m
        raster = crop(data, name)
        for spacings in QUICK_ERRORS if quick else ERRORS:
            _measure_all(results, raster, spacings, spacings * spacing, not quick and spacings == SLOW_RIVALS_ERROR)
    print_tables(results)


def _measure_all(results, raster, spacings, error_m, slow_too):
    def once(method, make):
        def figures():
            made = make()
            return made | ({"bits_per_sample": 8 * made["bytes"] / raster.samples} if "bytes" in made else {})

        return results.once("quality", figures, data=raster.name, spacings=spacings, error_m=error_m, method=method)

    for name, options in tintree.METHODS.items():
        for cut, tile in CUTS.items():
            if cut == "default tiles" or name in tintree.EFFORTS:
                once(f"tintree {name}, {cut}", lambda o=(*options, *tile): leaf_level(raster, error_m, o))
    for rival in MESH_RIVALS:
        if rival.slow and not slow_too:
            continue
        asked = once(rival.name, lambda r=rival: simplify(r, raster, error_m))
        if rival.fit and asked["samples_max_m"] > error_m:
            once(f"{rival.name}, fitted", lambda r=rival: _fitted(r, raster, error_m))
    for name in RASTER_CODERS:
        once(name, lambda n=name: code(n, raster, error_m))


def _fitted(rival, raster, error_m):
    best = largest_within(lambda e: simplify(rival, raster, e), error_m, error_m / 2, error_m / 256, error_m, 8)
    return best or {"remark": "beyond the error whatever was asked"}


def leaf_level(raster, error_m, options):
    """The leaf level: its mesh by the common meter, its bytes as stored, its share of the whole processor time."""
    report, cost = tintree.build(raster, "--error", repr(error_m), "--threads", "1", *options)
    leaves = report["levels"][-1]
    mesh, _ = tintree.export(leaves["level"])
    measured = measure(raster, mesh, 0)
    if not math.isclose(measured["surface_max_m"], leaves["vertical_max_m"], rel_tol=1e-9):
        raise RuntimeError(f"two measures disagree: {measured['surface_max_m']} m here, {leaves['vertical_max_m']} m in the tree")
    share = leaves["thread_seconds"] / sum(level["thread_seconds"] for level in report["levels"])
    return {"asked_m": error_m, **measured, "bytes": leaves["bytes"], "seconds": share * cost.cpu_seconds,
            "level": leaves["level"], "tree_bytes": report["payload_bytes"], "peak_rss_bytes": cost.peak_rss_bytes,
            "command": cost.command}


def print_tables(results):
    records = results.of("quality")
    for key in dict.fromkeys((r["data"], r["spacings"], r["error_m"]) for r in records):
        rows = [r for r in records if (r["data"], r["spacings"], r["error_m"]) == key]
        delatin = next((r["triangles"] for r in rows if r["method"] == "delatin"), None)
        print_table(f"{key[0]}, error {key[1]:g} spacings = {key[2]:.5g} m", _HEADER, [_cells(r, delatin) for r in rows])


def _beyond(r, key):
    """In bold where it exceeds the error."""
    if key not in r:
        return None
    return f"**{number(r[key])}**" if r[key] > r["error_m"] * (1 + 1e-9) else number(r[key])


_HEADER = ["method", "asked m", "max at samples m", "max of surface m", "RMS m", "triangles", "/ delatin", "bytes",
           "bits a sample", "s", "remarks"]


def _cells(r, delatin):
    remarks = [f"{number(r[key])} {what}" for key, what in (("uncovered_samples", "samples uncovered"),
                                                            ("folded_triangles", "triangles folded or flat")) if r.get(key)]
    remarks += [r["remark"]] if "remark" in r else []
    triangles = r.get("triangles")
    return [r["method"], number(r.get("asked_m")), _beyond(r, "samples_max_m"), _beyond(r, "surface_max_m"), number(r.get("rms_m")),
            number(triangles), f"{triangles / delatin:.3f}" if triangles and delatin else None, number(r.get("bytes")),
            number(r.get("bits_per_sample")), number(r.get("seconds"), 3), "; ".join(remarks)]
