"""Our own rows: tintree-build with its options, and what it says of itself."""
import json
from functools import lru_cache

from programs import BIN, CACHE, run


@lru_cache
def efforts():
    """{row name: options}; one row as long as tintree-build knows no --effort."""
    if "--effort" in run(BIN / "tintree-build", "--help").output:
        return {"fast": ["--effort", "fast"], "best": ["--effort", "best"]}
    return {"default": []}


def missing_efforts():
    return "" if len(efforts()) > 1 else "This tintree-build has no --effort: one row in place of fast and best."


TREE = CACHE / "tree.tintree"


def build(raster, *options, limit_s=None):
    """Builds CACHE/tree.tintree; returns its JSON and its cost."""
    report = CACHE / "tree.json"
    command = [BIN / "tintree-build", raster.path, "-o", TREE, "--overwrite", "--quiet", "--json", report, *options]
    cost = run(*command, limit_s=limit_s)
    return json.loads(report.read_text()), cost


def export(level):
    mesh = CACHE / "tree.ply"
    cost = run(BIN / "tintree-export", TREE, "--to", "ply", "--level", level, "-o", mesh, "--overwrite", "--quiet")
    return mesh, cost
