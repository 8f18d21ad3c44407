"""The simplifiers that tintree is compared with. A rival is a row of MESH_RIVALS."""
from dataclasses import dataclass
from typing import Callable

from datasets import raw_heights
from programs import BENCH, BIN, CACHE, ROOT, run


def bench_rivals(raster, *parts, grid=None, limit_s=None):
    """`grid`: a file of other heights of the same shape."""
    columns, rows = raster.size
    dx, dy = raster.spacing_m
    shape = ["--columns", columns, "--rows", rows, "--dx", repr(dx), "--dy", repr(dy)]
    return run(BIN / "bench_rivals", grid or raw_heights(raster), *shape, *parts, limit_s=limit_s)


def measure(raster, mesh, height_step_m, error_map=None):
    """What the mesh's error really is, and its bytes under Draco on its own lattice (0: not coded)."""
    into = ["--map", error_map] if error_map else []
    return bench_rivals(raster, "measure", mesh, "--height-step", repr(height_step_m), *into).json()


def _ours(method):
    return lambda raster, error, mesh, limit_s=None: bench_rivals(raster, "simplify", method, repr(error), mesh, limit_s=limit_s)


def _script(*start):
    def make(raster, error, mesh, limit_s=None):
        dx, dy = raster.spacing_m
        return run(*start, raw_heights(raster), *raster.size, repr(dx), repr(dy), repr(error), mesh, limit_s=limit_s)

    return make


@dataclass(frozen=True)
class MeshRival:
    name: str
    make: Callable  # (raster, error asked in metres, PLY to write, limit_s) -> Cost; prints {"seconds": ...}
    fit: bool = False  # also ask for less until the true error at the samples is within the bound
    slow: bool = False  # measured at one error only, and not by --quick
    height_step: Callable = lambda error_m: 1.0  # vertices lie at samples, whose heights are whole metres


MESH_RIVALS = [
    MeshRival("delatin", _script("node", BENCH / "simplify.js", "delatin")),
    MeshRival("martini", _script("node", BENCH / "simplify.js", "martini"), fit=True),
    MeshRival("meshoptimizer", _ours("meshoptimizer"), fit=True),
    MeshRival("VTK greedy", _script("/usr/bin/python3", ROOT / "tests/bench/rivals/vtk_greedy.py")),
    MeshRival("OpenMesh", _ours("openmesh"), slow=True),
    MeshRival("CGAL Lindstrom-Turk", _ours("lindstrom-turk"), slow=True, height_step=lambda error_m: error_m / 16),
]


def simplify(rival, raster, error_m):
    """One row: figures of the mesh that the rival makes when asked for this error."""
    mesh = CACHE / "rival.ply"
    cost = rival.make(raster, error_m, mesh)
    return {"asked_m": error_m, **measure(raster, mesh, rival.height_step(error_m)), **cost.json(), "peak_rss_bytes": cost.peak_rss_bytes,
            "command": cost.command}
