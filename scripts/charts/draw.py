"""Draws charts as SVG; the same records give the same bytes."""
import matplotlib

matplotlib.use("svg")
matplotlib.rcParams.update({
    "svg.hashsalt": "tintree", "svg.fonttype": "none", "font.size": 9, "axes.titlesize": 10, "axes.labelsize": 9, "xtick.labelsize": 8, "ytick.labelsize": 8,
    "axes.grid": True, "grid.color": "#dddddd", "grid.linewidth": 0.6, "axes.edgecolor": "#888888", "axes.axisbelow": True,
})

import matplotlib.pyplot as plt
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

from panels import points
from pareto import front
from series import SERIES

PANEL_WIDTH, PANEL_HEIGHT, MARGIN = 3.1, 2.6, 1.15  # inches
OVERVIEW_COLUMNS, OVERVIEW_WIDTH = 2, 5.4
LEAST_SPAN = 3  # of an axis, so that no difference looks larger than it is
FRONT = {"color": "#cccccc", "linewidth": 4, "solid_capstyle": "round", "solid_joinstyle": "round", "zorder": 1}
RING = {"marker": "o", "markersize": 10, "markerfacecolor": "none", "markeredgecolor": "black", "markeredgewidth": 0.8}


def _limits(low, high):
    widen = max(1.0, LEAST_SPAN / (high / low)) ** 0.5
    return low / widen, high * widen


def _ticks(axis, limits):
    low, high = limits
    few = high / low > 300
    axis.set_major_locator(LogLocator(subs=(1.0,) if few else (1.0, 2.0, 5.0), numticks=12))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_locator(NullLocator())


def _panel(axes, panel, by_series):
    for series in SERIES:
        values = by_series.get(series.name)
        if values:
            axes.plot(*zip(*values), color=series.color, marker=series.marker, linestyle=series.line, markersize=5, linewidth=1.4, zorder=3)
    if panel.front:
        best = front([p for values in by_series.values() for p in values])
        axes.plot(*zip(*best), drawstyle="steps-post", **FRONT)
        axes.plot(*zip(*best), linestyle="none", **RING, zorder=4)
    if panel.unity:
        axes.axhline(1, color="black", linewidth=1, zorder=2)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel(panel.x.label)


def _legend(figure, shown, marks_front):
    handles = [Line2D([], [], color=s.color, marker=s.marker, linestyle=s.line, label=s.name) for s in SERIES if s.name in shown]
    if marks_front:
        handles.append(Line2D([], [], **{**FRONT, "zorder": 2}, **RING, label="beaten by none"))
    figure.legend(handles=handles, loc="lower center", ncol=min(6, len(handles)), frameon=False, fontsize=9)


def _layout(chart, records):
    """Rows of (panel, terrain)."""
    if chart.terrain:
        cells = [(panel, chart.terrain) for panel in chart.panels]
        return [cells[i : i + OVERVIEW_COLUMNS] for i in range(0, len(cells), OVERVIEW_COLUMNS)]
    kinds = {panel.kind for panel in chart.panels}
    terrains = list(dict.fromkeys(r["data"] for r in records if r["kind"] in kinds))
    return [[(panel, terrain) for terrain in terrains] for panel in chart.panels]


def _chart(chart, records, path):
    layout = _layout(chart, records)
    rows, columns = len(layout), len(layout[0])
    height = PANEL_HEIGHT * rows + MARGIN
    width = (OVERVIEW_WIDTH if chart.terrain else PANEL_WIDTH) * columns
    figure, grid = plt.subplots(rows, columns, figsize=(width, height), sharey=False if chart.terrain else "row", squeeze=False)
    shown = set()
    for i, (row, cells) in enumerate(zip(grid, layout)):
        for j, (axes, (panel, terrain)) in enumerate(zip(row, cells)):
            by_series = points(panel, records, terrain)
            shown |= set(by_series)
            axes.set_visible(bool(by_series))
            if chart.terrain or j == 0:
                axes.set_ylabel(panel.y.label)
            if i == 0 and not chart.terrain:
                axes.set_title(terrain)
            if by_series:
                _panel(axes, panel, by_series)
        for axes in row:
            axes.set(xlim=_limits(*axes.get_xlim()), ylim=_limits(*axes.get_ylim()))
            _ticks(axes.xaxis, axes.get_xlim())
            _ticks(axes.yaxis, axes.get_ylim())
    _legend(figure, shown, any(panel.front for panel in chart.panels))
    figure.suptitle(chart.title, fontsize=12, fontweight="bold", y=1 - 0.12 / height)
    figure.tight_layout(rect=(0, 0.62 / height, 1, 1 - 0.02 / height))
    figure.savefig(path, metadata={"Date": None})
    plt.close(figure)


def charts(which, records, folder, suffix=".svg"):
    """Draws those of the charts that the records have figures for; returns the files."""
    files = []
    for chart in which:
        if any(points(panel, records, terrain) for row in _layout(chart, records) for panel, terrain in row):
            files.append((folder / chart.file).with_suffix(suffix))
            _chart(chart, records, files[-1])
    return files
