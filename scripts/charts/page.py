"""docs/charts/README.md: the charts, what they show, and by what factors methods differ."""
from compare import factor
from panels import CHARTS, points
from results import number
from series import BASE, SERIES
from windows import WINDOWS

_HEAD = """# Charts

Made by `scripts/chart` on {dates}, {machines}; drawn again from [results.jsonl](results.jsonl) by `scripts/chart --draw-only`. Each line
of that file is one figure in the charts, with the command that made it. Times are processor time. What the charts say:
[performance.md](../performance.md).

Errors are vertical and measured, not those asked for: of meshes by one meter (`tests/bench/rivals/mesh_error.h`), of rasters by
decoding them. tintree's leaves are its default tiles, with the borders that they share. Black rings: no other has both a smaller
error and a smaller figure.

| terrain | what |
|---|---|
{windows}

"""
_FACTORS = """
Factors over {base}, as geometric means over the sweep, at the same largest error / at the same RMS error. Below 1: less than
{base} needs.

"""


def _cell(panels, records, series, data):
    factors = []
    for panel in panels:
        by_series = points(panel, records, data)
        factors.append(factor(by_series.get(series, []), by_series.get(BASE, [])))
    return " / ".join(number(f, 3) or "–" for f in factors) if any(factors) else ""


def _factors(chart, records, terrains):
    rows = [(s.name, [_cell(chart.panels, records, s.name, data) for data in terrains]) for s in SERIES if s.name != BASE]
    rows = [(name, cells) for name, cells in rows if any(cells)]
    if not rows:
        return ""
    lines = ["| method | " + " | ".join(terrains) + " |", "|" + "---|" * (len(terrains) + 1)]
    lines += [f"| {name} | " + " | ".join(cells) + " |" for name, cells in rows]
    return _FACTORS.format(base=BASE) + "\n".join(lines) + "\n"


def _section(chart, folder, records, terrains):
    if not (folder / chart.file).exists():
        return ""
    compared = all(panel.front for panel in chart.panels) and len(chart.panels) > 1 and not chart.terrain
    return f"## {chart.title}\n{chart.about}\n\n![{chart.title}]({chart.file})\n{_factors(chart, records, terrains) if compared else ''}\n" \
           f"Made by `scripts/chart --only {chart.name}`.\n\n"


def write(folder, records):
    """Over all charts that lie in the folder."""
    terrains = list(dict.fromkeys(r["data"] for r in records))
    dates = sorted({r["date"] for r in records})
    head = _HEAD.format(dates=dates[0] if len(dates) == 1 else f"{dates[0]} to {dates[-1]}",
                        machines=", ".join(sorted({r["machine"] for r in records})),
                        windows="\n".join(f"| {w.name} | {w.file} from column {w.column}, row {w.row}: {w.about} |"
                                          for w in WINDOWS if w.name in terrains))
    path = folder / "README.md"
    path.write_text((head + "".join(_section(chart, folder, records, terrains) for chart in CHARTS.values())).rstrip() + "\n")
    return path
