"""Our own rows: tintree-build with its options, and what it says of itself."""
import json

from programs import BIN, CACHE, run


#: {row name: options} of the default method,
EFFORTS = {"fast": ["--effort", "fast"], "best": ["--effort", "best"]}
#: and of all that a tree can hold.
METHODS = {**EFFORTS, "strip": ["--method", "strip"], "strip best": ["--method", "strip", "--effort", "best"],
           **{name: ["--method", name] for name in ("nested", "wavelet", "scalar")}}

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
