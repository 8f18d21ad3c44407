"""docs/charts/results.jsonl: what the charts are drawn from, short enough to be kept in the repository."""
import json

DIGITS = 6
LEFT_OUT = ("key", "wall_seconds", "uncovered_samples", "folded_triangles")


def merged(old, new):
    """The new records, and those old ones of whose kind and terrain nothing was measured anew."""
    measured = {(r["kind"], r["data"]) for r in new}
    return [r for r in old if (r["kind"], r["data"]) not in measured] + new


def _short(record):
    return {k: float(f"{v:.{DIGITS}g}") if isinstance(v, float) else v for k, v in record.items() if k not in LEFT_OUT}


def write(path, records):
    """Returns them as they are in the file."""
    path.parent.mkdir(parents=True, exist_ok=True)
    short = [_short(r) for r in records]
    path.write_text("".join(json.dumps(r, separators=(",", ":")) + "\n" for r in short))
    return short
