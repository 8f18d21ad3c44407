"""docs/stability.md: the tables, round the text of stability_template.md."""
from pathlib import Path
from statistics import median

from contenders import CONTENDERS
from results import number

TEMPLATE = Path(__file__).with_name("stability_template.md")
FAMILIES = {"planes": "Planes and edges", "shapes": "Shapes", "holes": "Holes", "extremes": "Extremes of scale", "real": "Real terrain"}
ROUNDING = 1e-9  # by which an error may exceed the claim in the last digits
NAMES = [c.name for c in CONTENDERS]
OURS = {c.name for c in CONTENDERS if c.ours}
MESHES = [c.name for c in CONTENDERS if c.meshes]


def misses(row, key="surface"):
    """Whether the claimed error does not hold; None where there is no result."""
    return None if "outcome" in row else row[key] > 1 + ROUNDING or row.get("uncovered", 0) > 0


def breach_of_ours(method, row):
    """Ours may refuse what it cannot do, and say so; it may not break its word."""
    if method not in OURS:
        return False
    if "outcome" in row:
        return row["outcome"] != "refused"
    return bool(misses(row) or row["folded"] or row["filled"] or row["audit"])


def factor(value):
    if value <= 1 + ROUNDING:
        return f"{min(value, 1):.2f}"
    return f"**{number(value, 3) if value < 1e6 else f'{value:.0e}'}**"


def cell(row):
    if "outcome" in row:
        return f"*{row['outcome']}*"
    marks = "".join(mark for mark, key in (("u", "uncovered"), ("h", "filled"), ("f", "folded")) if row.get(key))
    if row["surface"] > 1 + ROUNDING >= row["samples"]:
        marks = "s" + marks
    return factor(row["surface"]) + (f" <sup>{marks}</sup>" if marks else "")


def said(row):
    """A row in a line."""
    if "outcome" in row:
        return f"{row['outcome']}: {row['message']}"
    size = f"{row['vertices']} vertices" if "vertices" in row else f"{row['bytes']} bytes"
    odd = "".join(f", {row[key]} {key}" for key in ("uncovered", "filled", "folded") if row.get(key)) + (
        f", audit: {row['audit']}" if row.get("audit") else "")  # fmt: skip
    return f"{row['surface']:.4g} of the claim over the surface, {row['samples']:.4g} at samples, {size}{odd}"


def table(header, rows):
    lines = ["| " + " | ".join(header) + " |", "|" + "---|" * len(header)]
    return "\n".join(lines + ["| " + " | ".join("" if c is None else str(c) for c in row) + " |" for row in rows])


def overview(atlas):
    rows = []
    for name in NAMES:
        mine = {t.name: rows_[name] for t, rows_ in atlas.items()}
        done = {t: r for t, r in mine.items() if "outcome" not in r}
        held = sum(not misses(r) for r in done.values())
        samples = sum(not misses(r, "samples") for r in done.values())
        worst = max(done, key=lambda t: done[t]["surface"], default=None)
        rows.append([name, held, samples - held, len(done) - samples, _outcomes(mine), f"{factor(done[worst]['surface'])} {worst}" if worst else None,
                     sum(r.get("filled", 0) > 0 for r in done.values()) or None, sum(r.get("folded", 0) > 0 for r in done.values()) or None,
                     _against_best(atlas, name), number(sum(r["seconds"] for r in done.values()), 3)])
    return table(["method", "holds", "holds at samples only", "does not hold", "no result", "worst, times the claim", "fills holes",
                  "folds", "vertices / tintree best", "s in all"], rows)


def _outcomes(mine):
    outcomes = [r["outcome"] for r in mine.values() if "outcome" in r]
    return ", ".join(f"{outcomes.count(o)} {o}" for o in dict.fromkeys(outcomes)) or None


def _against_best(atlas, name):
    """Median over the terrains where the method keeps its word over the surface."""
    ratios = [rows[name]["vertices"] / rows["tintree best"]["vertices"] for rows in atlas.values()
              if name in MESHES and not any("outcome" in rows[m] or misses(rows[m]) for m in (name, "tintree best"))
              and rows["tintree best"]["vertices"] > 100]
    return f"{median(ratios):.2f} ({len(ratios)})" if ratios else None


def family_tables(members):
    size = lambda r: None if "outcome" in r else number(r.get("vertices", r.get("bytes")))
    seconds = lambda r: None if "outcome" in r else number(r["seconds"], 2)
    parts = [table(["terrain", "error asked, m", *NAMES], [[t.name, f"{next(iter(rows.values()))['error_m']:.3g}", *(cell(rows[n]) for n in NAMES)] for t, rows in members.items()])]
    for title, show in (("Vertices of meshes, bytes of coders", size), ("Processor seconds", seconds)):
        rows = [[t.name, *(show(rows[n]) for n in NAMES)] for t, rows in members.items()]
        parts.append(f"<details><summary>{title}</summary>\n\n{table(['terrain', *NAMES], rows)}\n\n</details>")
    return "\n\n".join(parts)


def excuses(members):
    """What those said that gave no result."""
    groups = {}
    for t, rows in members.items():
        for name, row in rows.items():
            if "outcome" in row:
                groups.setdefault((name, row["outcome"], shortened(row["message"])), []).append(t.name)
    return "\n".join(f"- {name} on {', '.join(names)}: {outcome}, \"{message}\"" for (name, outcome, message), names in groups.items())


def shortened(message):
    """Without the place in the file system, and in a line's length."""
    words = [w.rsplit("/", 1)[-1] if "/" in w else w for w in message.split()]
    text = " ".join(words).replace("|", "/")
    return text if len(text) <= 160 else text[:157] + "..."


def family_section(family, members, images):
    about = "\n".join(f"- **{t.name}** ({t.columns} x {t.rows}): {t.about}" for t in members)
    return (f"### {FAMILIES[family]}\n{about}\n\n![{FAMILIES[family]}: each terrain, and where methods err]({images}/{family}.png)\n\n"
            f"{family_tables(members)}\n\n{excuses(members)}".rstrip())


def page(atlas, images):
    families = dict.fromkeys(t.family for t in atlas)
    sections = [family_section(f, {t: rows for t, rows in atlas.items() if t.family == f}, images) for f in families]
    text = TEMPLATE.read_text()
    for place, content in (("{overview}", overview(atlas)), ("{terrains}", "\n\n".join(sections)), ("{count}", str(len(atlas)))):
        text = text.replace(place, content)
    return text
