"""The methods of the atlas: ours and the rivals. A method is a row of CONTENDERS."""
import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Callable

import numpy as np
from osgeo import gdal

import tintree
from datasets import raw_heights
from memo import digest
from programs import BENCH, BIN, CACHE, ROOT, Failed, run
from raster_coders import coded, jpeg2000, jpeg2000_rms, jpegls, lerc
from rivals import MESH_RIVALS, measure

SCRIPTS = ROOT / "scripts" / "benchmarks"
MESH = CACHE / "atlas.ply"
OUR_TILE = "64"  # several tiles and levels even of small terrains


@dataclass(frozen=True)
class Contender:
    name: str
    attempt: Callable  # (raster, error in metres, file for the error map, time limit in s) -> figures; raises Failed
    tools: tuple  # files that decide what comes out
    ours: bool = False
    meshes: bool = True


def _tree(*options):
    """Every level of a tree by the common meter, against its own bound; the whole tree by the audit."""

    def attempt(raster, error_m, error_map, limit_s):
        command = ["--error", repr(error_m), "--tile", OUR_TILE, "--threads", "1", *options]
        report, cost = tintree.build(raster, *command, limit_s=limit_s)
        figures = {"vertices": 0, "triangles": 0, "samples": 0, "surface": 0, "uncovered": 0, "filled": 0, "folded": 0,
                   "seconds": cost.cpu_seconds, "command": cost.command, "levels": len(report["levels"])}  # fmt: skip
        for level in report["levels"]:
            bound_m = error_m * 2.0 ** (len(report["levels"]) - 1 - level["level"])
            mesh, _ = tintree.export(level["level"])
            leaves = level is report["levels"][-1]
            _merge(figures, measure(raster, mesh, 0, error_map if leaves else None), bound_m, counts=leaves)
        figures["audit"] = _audit(raster)
        return figures

    return attempt


def _merge(figures, measured, bound_m, counts):
    for key in ("samples", "surface"):
        figures[key] = max(figures[key], measured[f"{key}_max_m"] / bound_m)
    for key in ("uncovered", "filled", "folded"):
        name = "folded_triangles" if key == "folded" else f"{key}_samples"
        figures[key] = max(figures[key], measured[name])
    if counts:
        figures["vertices"], figures["triangles"] = measured["vertices"], measured["triangles"]


def _audit(raster):
    try:
        run(BIN / "tintree-audit", tintree.TREE, "--dem", raster.path, "--hausdorff-tiles", "0", "--quiet")
    except Failed as failed:
        return f"{failed.outcome}: {failed.message}"
    return ""


def _mesh(rival):
    def attempt(raster, error_m, error_map, limit_s):
        cost = rival.make(raster, error_m, MESH, limit_s=limit_s)
        figures = {"samples": 0, "surface": 0, "uncovered": 0, "filled": 0, "folded": 0, **cost.json(), "command": cost.command}
        _merge(figures, measure(raster, MESH, 0, error_map), error_m, counts=True)
        return figures

    return attempt


def _coder(coder):
    def attempt(raster, error_m, error_map, limit_s):
        try:
            figures, distance = coded(coder, raster, error_m)
        except RuntimeError as error:  # GDAL's
            if isinstance(error, Failed):
                raise
            message = str(error) or gdal.GetLastErrorMsg() or "GDAL does not say why"
            raise Failed("refused", message.splitlines()[-1], coder.__name__) from error
        if distance is not None:
            distance.astype(np.float32).tofile(error_map)
        return {"samples": figures["samples_max_m"] / error_m, "surface": figures["surface_max_m"] / error_m,
                **{key: figures[key] for key in ("bytes", "seconds", "command")}}  # fmt: skip

    return attempt


_OURS = (BIN / "tintree-build", BIN / "tintree-export", BIN / "tintree-audit", BIN / "bench_rivals")
_RIVALS = (BIN / "bench_rivals", BENCH / "simplify.js", BENCH / "package-lock.json", ROOT / "tests/bench/rivals/vtk_greedy.py")
_CODERS = (BIN / "bench_rivals", SCRIPTS / "raster_coders.py", SCRIPTS / "fitting.py")

CONTENDERS = [
    Contender("tintree fast", _tree("--effort", "fast"), _OURS, ours=True),
    Contender("tintree best", _tree("--effort", "best"), _OURS, ours=True),
    *(Contender(f"tintree {name}", _tree("--method", name), _OURS, ours=True) for name in ("strip", "nested", "wavelet", "scalar")),
    *(Contender(rival.name, _mesh(rival), _RIVALS) for rival in MESH_RIVALS),
    Contender("LERC", _coder(lerc), _CODERS, meshes=False),
    Contender("JPEG-LS", _coder(jpegls), _CODERS, meshes=False),
    Contender("JPEG 2000", _coder(jpeg2000), _CODERS, meshes=False),
    Contender("JPEG 2000 by RMS", _coder(jpeg2000_rms), _CODERS, meshes=False),
]


@lru_cache
def tools_digest(tools):
    return digest(gdal.VersionInfo(), *tools)


def meet(contender, raster, error_m, error_map, limit_s):
    """One row: figures in claimed errors, or the outcome."""
    raw_heights(raster)
    try:
        figures = contender.attempt(raster, error_m, error_map, limit_s)
    except Failed as failed:
        return {"outcome": failed.outcome, "message": failed.message}
    if not all(math.isfinite(figures[key]) for key in ("samples", "surface")):
        return {"outcome": "refused", "message": "the result holds heights that are no numbers"}
    return figures
