"""The measurements behind the charts: which there are, and doing those that have not been done."""
import sys
import time
from dataclasses import dataclass

import frames
import measure
import memo
import windows
from programs import BIN, cpu_name
from progress import Progress
from series import SERIES

ERRORS = (0.1, 0.2, 0.5, 1, 2, 4)  # sample spacings
PIXEL_ERRORS = (0.25, 0.5, 1, 2, 4, 8)
VIEW_ERROR = 0.1  # of the views' tree, in sample spacings
SIZE_ERROR = 0.5  # sample spacings: what tintree-build takes if nothing is said
SIZE_SPEED = 3e6  # samples a second to expect
QUICK_ERRORS, QUICK_PIXEL_ERRORS = (0.5, 2), (1, 4)
PICTURE_SECONDS = 1  # to expect of one that was never made


@dataclass(frozen=True)
class Task:
    kind: str  # level: one level within an error; frame: a picture of all of it; view: one within a pixel error; size: a whole tree
    window: windows.Window | windows.Size
    series: object
    spacings: float  # the error of the level, or of the view's tree
    pixel_error: float = 0

    @property
    def name(self):
        """Of the figures in a chart, whatever program made them."""
        return {"kind": self.kind, "data": self.window.name, "series": self.series.name, "spacings": self.spacings,
                **({"pixel_error": self.pixel_error} if self.kind == "view" else {}),
                **({"samples": self.window.samples} if self.kind == "size" else {})}

    def text(self):
        error = f"{self.pixel_error:g} pixels" if self.kind == "view" else f"{self.spacings:g} spacings"
        size = f" of {self.window.samples / 1e6:.0f} M samples" if self.kind == "size" else ""
        return f"{self.window.name}, {self.series.name}, {error}, {self.kind}{size}"

    @property
    def typical_seconds(self):
        """Of a measurement that was never made."""
        if self.kind == "size":
            return self.window.samples / SIZE_SPEED
        return self.series.seconds if self.kind == "level" else PICTURE_SECONDS


def _measured(series, window, spacings, quick):
    if series.errors and (quick or spacings not in series.errors):
        return False
    return not series.terrains or window.name in series.terrains


def _size_tasks(size):
    return [Task("size", size, series, SIZE_ERROR) for series in SERIES if series.kind == "tree" and size.samples <= series.most_samples]


def _window_tasks(window, kinds, quick):
    out = []
    for series in SERIES:
        for spacings in QUICK_ERRORS if quick else ERRORS:
            if not _measured(series, window, spacings, quick):
                continue
            if {"level", "frame"} & kinds:
                out.append(Task("level", window, series, spacings))
            if "frame" in kinds and series.kind == "tree":
                out.append(Task("frame", window, series, spacings))
        if "view" in kinds and series.kind == "tree":
            out += [Task("view", window, series, VIEW_ERROR, p) for p in (QUICK_PIXEL_ERRORS if quick else PIXEL_ERRORS)]
    return out


def tasks(found, kinds, quick):
    """All that the charts of these kinds of records show, over the windows and sizes `found`."""
    return [task for where in found
            for task in (_size_tasks(where) if isinstance(where, windows.Size) else _window_tasks(where, kinds, quick))]


class Sweep:
    def __init__(self, rasters, store):
        self.rasters, self.store = rasters, store  # {window: Raster}
        self.done, self.failed = [], []

    def _level_key(self, task):
        return memo.key(task.series.programs, [self.rasters[task.window].path], kind=task.series.kind, series=task.series.name,
                         options=task.series.options, spacings=task.spacings)

    def key(self, task):
        if task.kind == "level":
            return self._level_key(task)
        if task.kind == "size":
            return memo.key((BIN / "tintree-build",), [self.rasters[task.window].path], kind="size", options=task.series.options)
        return memo.key(frames.PROGRAMS, [], tree=self._tree_key(task), pixel_error=task.pixel_error, size=frames.SIZE)

    def _tree_key(self, task):
        return self._level_key(task) + ("" if task.kind == "frame" else f"-{measure.VIEW_TILE}")

    def _figures(self, task):
        raster, series = self.rasters[task.window], task.series
        error_m = task.spacings * raster.mean_spacing_m
        if task.kind == "level":
            return measure.level(series, raster, task.window.scale, error_m, self._level_key(task))
        if task.kind == "size":
            return measure.size(series, raster)
        if task.kind == "view":
            return measure.view(series, raster, error_m, task.pixel_error, self._tree_key(task))
        level = self.store.get(self._level_key(task))
        errors = {name: level[name] for name in ("samples_max_m", "rms_m")}
        return {**errors, **measure.leaf_frame(series, raster, error_m, self._tree_key(task))}

    def _expected_seconds(self, task):
        """As long as the same took with an older program, or as is typical."""
        name = task.name
        before = [r["wall_seconds"] for r in self.store.records.values() if all(r.get(k) == v for k, v in name.items())]
        return before[-1] if before else task.typical_seconds

    def run(self, planned):
        """Measures what is not in the store. Their records, in the plan's order, are in `done`, what failed in `failed`."""
        keys = {task: self.key(task) for task in planned}
        missing = [task for task in planned if self.store.get(keys[task]) is None]
        missing.sort(key=lambda task: (task.kind == "frame", task.typical_seconds))  # slow ones last; frames need their levels
        progress = Progress(len(planned), {task: self._expected_seconds(task) for task in missing})
        for task in missing:
            progress.begin(task, task.text())
            self._measure(task, keys[task])
        self.done = [self.store.get(keys[task]) for task in planned if self.store.get(keys[task])]

    def _measure(self, task, key):
        start = time.monotonic()
        try:
            figures = self._figures(task)
        except (RuntimeError, TypeError) as error:  # TypeError: a frame whose level failed
            print(f"    failed: {error}", file=sys.stderr)
            self.failed.append(f"{task.text()}: {error}")
            return
        self.store.put(key, {**task.name, **figures, "date": time.strftime("%Y-%m-%d"), "machine": cpu_name(),
                             "wall_seconds": round(time.monotonic() - start, 3)})
