"""One measurement of each kind: its figures, in metres of the real terrain."""
import shutil

import quality
import raster_coders
import rivals
import tintree
from frames import frame
from programs import BENCH, BIN, run, shown

TREES = BENCH / "charts" / "trees"
LENGTHS = ("asked_m", "samples_max_m", "surface_max_m", "rms_m")
KEPT = (*LENGTHS, "bytes", "tree_bytes", "vertices", "triangles", "seconds", "decode_seconds", "peak_rss_bytes", "level",
        "uncovered_samples", "folded_triangles", "command")
#: The views' tree: many small tiles, so that every pixel error finds a level that fits it.
VIEW_TILE = "64"


def _kept_tree(key):
    """What tintree.build left, under the measurement's name: frames are drawn of it later."""
    TREES.mkdir(parents=True, exist_ok=True)
    return shutil.move(tintree.TREE, TREES / f"{key}.tintree")


def _tree(series, raster, error_m, key):
    figures = quality.leaf_level(raster, error_m, list(series.options))
    decoded = run(BIN / "bench_decode", tintree.TREE, figures["level"]).json()
    _kept_tree(key)
    return {**figures, "decode_seconds": decoded["decode_seconds"]}


def _mesh(series, raster, error_m, _):
    rival = next(r for r in rivals.MESH_RIVALS if r.name == series.name)
    return rivals.simplify(rival, raster, error_m)


def _raster(series, raster, error_m, _):
    figures = raster_coders.code(series.name, raster, error_m)
    if raster.path.stem not in figures["command"]:
        figures["command"] += f" of {shown(raster.path)}"
    return {"asked_m": error_m, **figures}


_LEVELS = {"tree": _tree, "mesh": _mesh, "raster": _raster}


def level(series, raster, scale, error_m, key):
    """One level of the terrain within `error_m`, lengths of the file; what it costs and how far off it really is."""
    figures = _LEVELS[series.kind](series, raster, error_m, key)
    out = {name: figures[name] for name in KEPT if figures.get(name) is not None}
    for name in LENGTHS:
        out[name] = out[name] / scale
    return {**out, "bytes_per_sample": out["bytes"] / raster.samples}


def leaf_frame(series, raster, error_m, key):
    """A picture of the whole level that level() measured under `key`."""
    tree = TREES / f"{key}.tintree"
    if not tree.exists():
        tintree.build(raster, "--error", repr(error_m), "--threads", "1", *series.options)
        _kept_tree(key)
    return frame(tree, 0.0)


def view(series, raster, error_m, pixel_error, key):
    """A picture within `pixel_error` of the tree whose leaves are within `error_m`."""
    tree = TREES / f"{key}.tintree"
    if not tree.exists():
        tintree.build(raster, "--error", repr(error_m), "--threads", "1", "--tile", VIEW_TILE, *series.options)
        _kept_tree(key)
    return frame(tree, pixel_error)


def size(series, raster):
    """The whole build of a raster, all levels at the default error."""
    report, cost = tintree.build(raster, *series.options)
    return {"samples": raster.samples, "wall_s": report["seconds"], "cpu_seconds": cost.cpu_seconds, "tree_bytes": report["bytes"],
            "peak_rss_bytes": cost.peak_rss_bytes, "command": cost.command}
