"""Contact sheets: a row a terrain, with the terrain and where methods err, in claimed errors."""
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import LogNorm
from PIL import Image

import terrains
from contenders import CONTENDERS

WORST = 4
OURS = next(c for c in CONTENDERS if c.name == "tintree best")
CELL_IN, LEGEND_IN, DPI = 1.25, 0.3, 72
PALETTE = 40  # colours of a sheet, to keep it small
#: Blue within the claim, yellow to black beyond.
SCALE = LogNorm(0.1, 1000)
COLOURS = matplotlib.colors.LinearSegmentedColormap.from_list(
    "errors", [(0, "#ffffff"), (0.2499, "#9ecae1"), (0.25, "#fed976"), (0.5, "#f03b20"), (1, "#4a0010")])


def relief(heights, spacing_m):
    """Shaded from the north-west, steepness taken relative to the terrain's own."""
    filled = np.where(np.isnan(heights), np.nanmean(heights), heights)
    if min(filled.shape) < 2:
        return filled
    south, east = np.gradient(filled, *spacing_m[::-1])
    steep = np.percentile(np.hypot(south, east), 90) or np.hypot(south, east).max() or 1
    south, east = south / steep, east / steep
    shade = (1 + 0.7 * (east + south) / 2) / np.sqrt(1 + east**2 + south**2)
    return np.where(np.isnan(heights), np.nan, shade)


def title(name, surface):
    return f"{name}: {surface:.2f}" if surface <= 1 else f"{name}: {surface:.3g} x"


def strip(picture, side=257):
    """A long ribbon is cut to its first part."""
    return picture[:side, :side]


def offenders(rows):
    """The methods that miss the claim most, the worst first."""
    able = [c for c in CONTENDERS if "outcome" not in rows[c.name] and rows[c.name]["surface"] > 1 + 1e-9]
    return sorted(able, key=lambda c: -rows[c.name]["surface"])[:WORST]


def draw(path, members, data, map_of):
    figure, grid = plt.subplots(len(members), WORST + 2, figsize=((WORST + 2) * CELL_IN, len(members) * (CELL_IN + 0.12)), squeeze=False)
    for cells, (terrain, rows) in zip(grid, members.items()):
        raster = terrains.raster_of(terrain, data)
        heights, valid = raster.heights()
        shade = relief(np.where(valid, heights, np.nan), raster.spacing_m)
        show(cells[0], strip(shade), terrain.name, cmap="gray", vmin=0, vmax=1.6)
        shown = [OURS] if "outcome" not in rows[OURS.name] else []
        for cell, contender in zip(cells[1:], shown + offenders(rows)):
            file = map_of(terrain, contender)
            if not file.exists():
                continue
            errors = np.fromfile(file, np.float32).reshape(valid.shape) / rows[contender.name]["error_m"]
            show(cell, strip(np.maximum(errors, 0.1)), title(contender.name, rows[contender.name]["surface"]), cmap=COLOURS, norm=SCALE)
    for cell in grid.flat:
        if not cell.images:
            cell.set_axis_off()
        cell.set_xticks([])
        cell.set_yticks([])
        plt.setp(cell.spines.values(), color="#b0b0b0", linewidth=0.5)
    height_in = figure.get_figheight()
    figure.subplots_adjust(0.005, LEGEND_IN / height_in, 0.995, 1 - 0.17 / height_in, 0.05, 0.16)
    legend(figure, height_in)
    figure.savefig(path, dpi=DPI)
    plt.close(figure)
    with Image.open(path) as sheet:
        small = sheet.convert("RGB").quantize(PALETTE, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)
    small.save(path, optimize=True)


def legend(figure, height_in):
    bar = figure.add_axes((0.3, (LEGEND_IN - 0.14) / height_in, 0.4, 0.08 / height_in))
    figure.colorbar(matplotlib.cm.ScalarMappable(SCALE, COLOURS), cax=bar, orientation="horizontal")
    bar.set_xticks([0.1, 1, 10, 100, 1000], ["0.1", "1", "10", "100", "1000 times the claim"])
    bar.tick_params(labelsize=6, length=2, pad=1)


def show(cell, picture, caption, **how):
    colours = matplotlib.colormaps[how["cmap"]] if isinstance(how["cmap"], str) else how["cmap"]
    colours = colours.copy()
    colours.set_bad("#d8d0c0")
    cell.imshow(picture, interpolation="nearest", **{**how, "cmap": colours})
    cell.set_title(caption, fontsize=6, pad=1.5)
