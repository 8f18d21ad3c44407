"""Table 2: bits of whole trees, beside coders that hold one level of the raster at the same largest error."""
import tintree
from datasets import DEMS, crop, whole
from raster_coders import RASTER_CODERS, code
from results import number, print_table

_EFFORTS = [f"tintree {effort}" for effort in tintree.EFFORTS]
ERRORS = (0.1, 0.2, 0.5, 1, 2, 4)  # sample spacings


def run(results, data, quick):
    for name in DEMS:
        raster = crop(data, name) if quick else whole(data, name)
        spacing = raster.mean_spacing_m
        _check_spacing(raster, spacing)
        for spacings in ERRORS:
            common = {"data": raster.name, "spacings": spacings, "error_m": spacings * spacing}
            for method, options in tintree.METHODS.items():
                results.once("trees", lambda o=options: _tree(raster, common["error_m"], o), **common, method=f"tintree {method}")
            for coder in RASTER_CODERS:
                results.once("trees", lambda c=coder: _coded(raster, common["error_m"], c), **common, method=coder)
    print_tables(results)


def _tree(raster, error_m, options):
    report, cost = tintree.build(raster, "--error", repr(error_m), *options)
    return {"bits_per_sample": report["bits_per_sample"], "file_bits_per_sample": report["file_bits_per_sample"],
            "vertices": report["vertices"], "bits_per_vertex": 8 * report["payload_bytes"] / report["vertices"],
            "samples_max_m": report["levels"][-1]["vertical_max_m"], "seconds": report["seconds"], "command": cost.command}


def _coded(raster, error_m, coder):
    figures = code(coder, raster, error_m)
    return {"bits_per_sample": 8 * figures["bytes"] / raster.samples, **figures}


def _check_spacing(raster, spacing):
    error_m = tintree.build(raster)[0]["error_m"]
    if abs(2 * error_m / spacing - 1) > 1e-6:
        raise RuntimeError(f"tintree-build takes {2 * error_m} m for the spacing, the benchmark {spacing} m")


def print_tables(results):
    records = results.of("trees")
    for data in dict.fromkeys(r["data"] for r in records):
        rows = [r for r in records if r["data"] == data]
        methods = list(dict.fromkeys(r["method"] for r in rows))
        trees = [m for m in methods if m.startswith("tintree")]
        bits = {(r["spacings"], r["method"]): r for r in rows}
        header = ["error, spacings", "error m"]
        header += [f"{m}, {what}" for m in _EFFORTS for what in ("bits a sample", "(file)", "bits a vertex")]
        header += [f"{m}, bits a sample" for m in methods if m not in _EFFORTS]
        print_table(f"{data}: all levels of the tree, one level of the others", header,
                    [_cells(s, bits, methods) for s in dict.fromkeys(r["spacings"] for r in rows)])
        print()
        for tree in trees:
            for coder in methods:
                if coder not in trees:
                    print(_from_where(bits, tree, coder))


def _cells(spacings, bits, methods):
    cells = [f"{spacings:g}", number(bits[spacings, methods[0]]["error_m"])]
    for effort in _EFFORTS:
        r = bits[spacings, effort]
        cells += [number(r["bits_per_sample"]), number(r["file_bits_per_sample"]), number(r["bits_per_vertex"])]
    return cells + [number(bits[spacings, m]["bits_per_sample"]) for m in methods if m not in _EFFORTS]


def _from_where(bits, tree, coder):
    smaller_from = None
    for spacings in sorted({s for s, _ in bits}, reverse=True):
        if bits[spacings, tree]["bits_per_sample"] >= bits[spacings, coder]["bits_per_sample"]:
            break
        smaller_from = spacings
    if smaller_from is None:
        return f"- {tree} is smaller than {coder} at none of these errors."
    return f"- {tree} is smaller than {coder} from {smaller_from:g} spacings on."
