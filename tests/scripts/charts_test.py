"""scripts/chart without its programs: fronts, keys, the rate search, what is measured again, and the drawing."""
import math
import random
import sys
import tempfile
import unittest
from pathlib import Path
from unittest import mock
from xml.etree import ElementTree

SCRIPTS = Path(__file__).resolve().parents[2] / "scripts"
sys.path[:0] = [str(SCRIPTS / "charts"), str(SCRIPTS / "benchmarks")]

import compare
import draw
import memo
import page
import programs
import record
import sweep
from fitting import largest_within
from panels import CHARTS
from pareto import front
from series import SERIES, Series
from windows import Size, WINDOWS


class Folder(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        memo.file_digest.cache_clear()

    def file(self, name, text):
        (self.folder / name).write_text(text)
        memo.file_digest.cache_clear()
        return self.folder / name


class Front(unittest.TestCase):
    def test_holds_exactly_what_no_other_beats(self):
        rng = random.Random(1)
        for count in (1, 2, 7, 60):
            points = [(rng.randrange(12), rng.randrange(12)) for _ in range(count)]
            beaten = lambda p: any(q[0] <= p[0] and q[1] <= p[1] and q != p for q in points)
            self.assertEqual(front(points), sorted({p for p in points if not beaten(p)}))

    def test_of_nothing_is_empty(self):
        self.assertEqual(front([]), [])


class Factor(unittest.TestCase):
    def test_between_parallel_lines_is_their_distance(self):
        line = lambda c, xs: [(x, c * x**-1.5) for x in xs]
        self.assertAlmostEqual(compare.factor(line(6, (2, 3, 5)), line(2, (1, 4, 9))), 3)

    def test_leaves_out_what_the_base_does_not_reach(self):
        base = [(1, 1), (10, 1)]
        self.assertAlmostEqual(compare.factor([(0.5, 99), (2, 4), (20, 99)], base), 4)
        self.assertIsNone(compare.factor([(0.5, 99)], base))
        self.assertIsNone(compare.factor([(2, 4)], []))


class Key(Folder):
    def test_changes_with_program_input_and_options_alone(self):
        program, dem = self.file("program", "1"), self.file("dem", "a")
        key = memo.key([program], [dem], error=1.0)
        self.assertEqual(key, memo.key([self.file("elsewhere", "1")], [dem], error=1.0))
        self.assertNotEqual(key, memo.key([program], [dem], error=2.0))
        self.assertNotEqual(key, memo.key([program], [self.file("dem", "b")], error=1.0))
        self.file("dem", "a")
        self.assertEqual(key, memo.key([program], [dem], error=1.0))
        self.assertNotEqual(key, memo.key([self.file("program", "2")], [dem], error=1.0))
        self.assertNotEqual(memo.key(["GDAL 3.6"], [dem]), memo.key(["GDAL 3.7"], [dem]))


class Store(Folder):
    def test_survives_a_line_that_was_cut_off(self):
        path = self.folder / "cache.jsonl"
        memo.Memo(path).put("a", {"seconds": 1})
        path.write_bytes(path.read_bytes() + b'{"key": "b", "sec')
        store = memo.Memo(path)
        self.assertEqual(store.get("a"), {"key": "a", "seconds": 1})
        self.assertIsNone(store.get("b"))
        store.put("c", {})
        self.assertEqual(set(memo.Memo(path).records), {"a", "c"})

    def test_keeps_old_figures_of_what_was_not_measured_again(self):
        old = [{"kind": "level", "data": "moon", "n": 1}, {"kind": "view", "data": "moon", "n": 2}, {"kind": "level", "data": "mars", "n": 3}]
        new = [{"kind": "level", "data": "moon", "n": 4}]
        self.assertEqual([r["n"] for r in record.merged(old, new)], [2, 3, 4])


class FakeCoder:
    """Its error grows in steps with the parameter, as those of real coders do."""

    def __init__(self, step):
        self.step, self.asked = step, []

    def error(self, parameter):
        return math.ceil(0.3 * parameter**1.2 / self.step) * self.step

    def __call__(self, parameter):
        self.asked.append(parameter)
        return {"samples_max_m": self.error(parameter), "parameter": parameter}


class RateSearch(unittest.TestCase):
    def test_comes_close_to_the_bound_and_stays_within(self):
        for bound in (1.5, 8, 59.2, 1000):
            coder = FakeCoder(step=bound / 200)
            best = largest_within(coder, bound, start=16, low=0.1, high=1e5, steps=12)
            self.assertLessEqual(best["samples_max_m"], bound)
            self.assertGreater(best["samples_max_m"], 0.95 * bound)
            self.assertLessEqual(len(coder.asked), 12)

    def test_of_a_coarse_coder_finds_a_parameter_within(self):
        coder = FakeCoder(step=5)
        best = largest_within(coder, 23.69, start=16, low=0.1, high=1e5, steps=12)
        self.assertEqual(best["samples_max_m"], 20)

    def test_says_when_nothing_is_within(self):
        self.assertIsNone(largest_within(FakeCoder(step=5), 1, start=16, low=2, high=100, steps=8))

    def test_stays_in_its_range(self):
        coder = FakeCoder(step=0.01)
        self.assertEqual(largest_within(coder, 1e9, start=16, low=2, high=100, steps=8)["parameter"], 100)
        self.assertTrue(all(2 <= p <= 100 for p in coder.asked))


class Resuming(Folder):
    """A sweep whose measurements are made up: which of them are made, and when again."""

    def run_sweep(self, program, fail=()):
        series = Series("ours", "tree", "#000000", "o", (), (program,))
        raster = mock.Mock(path=self.file("dem", "a"), mean_spacing_m=10.0)
        made = []

        def level(series, raster, scale, error_m, key):
            made.append(error_m)
            if error_m in fail:
                raise RuntimeError("exit code 1")
            return {"samples_max_m": error_m, "rms_m": error_m / 2}

        run = sweep.Sweep({WINDOWS[0]: raster}, memo.Memo(self.folder / "cache.jsonl"))
        with mock.patch.object(sweep, "SERIES", [series]), mock.patch("measure.level", level), mock.patch("sys.stderr"):
            run.run(sweep.tasks([WINDOWS[0]], {"level"}, quick=False))
        return made, run

    def test_measures_once_and_again_when_the_program_changes(self):
        program = self.file("program", "1")
        everything = [10 * e for e in sweep.ERRORS]
        self.assertEqual(self.run_sweep(program)[0], everything)
        made, run = self.run_sweep(program)
        self.assertEqual(made, [])
        self.assertEqual([r["samples_max_m"] for r in run.done], everything)
        self.assertEqual(self.run_sweep(self.file("program", "2"))[0], everything)

    def test_goes_on_after_a_failure_and_tries_it_again(self):
        program = self.file("program", "1")
        made, run = self.run_sweep(program, fail=(5.0,))
        self.assertEqual((len(made), len(run.done), len(run.failed)), (6, 5, 1))
        self.assertEqual(self.run_sweep(program)[0], [5.0])

    def test_slow_rivals_are_measured_where_they_are_listed_alone(self):
        slow = Series("slow", "mesh", "#000000", "o", seconds=99, terrains=("california",), errors=(0.5, 1))
        with mock.patch.object(sweep, "SERIES", [slow]):
            full, quick = (sweep.tasks(WINDOWS, {"level"}, quick) for quick in (False, True))
        self.assertEqual([(t.window.name, t.spacings) for t in full], [("california", 0.5), ("california", 1)])
        self.assertEqual(quick, [])

    def test_large_rasters_are_built_by_fast_methods_alone(self):
        fast, slow = (Series(name, "tree", "#000000", "o", most_samples=most) for name, most in (("fast", 1e9), ("slow", 1e8)))
        with mock.patch.object(sweep, "SERIES", [fast, slow, Series("mesh", "mesh", "#000000", "o")]):
            planned = sweep.tasks([Size(1025, 1025), Size(32769, 16385)], {"size"}, False)
        self.assertEqual([(t.series.name, t.window.columns) for t in planned], [("fast", 1025), ("slow", 1025), ("fast", 32769)])
        self.assertEqual(len({str(t.name) for t in planned}), 3)


def canned_records():
    for data in ("california", "moon", "rainier"):
        for i, series in enumerate(SERIES):
            for error in (10.0, 40.0):
                common = {"data": data, "series": series.name, "spacings": error / 100, "date": "2026-01-31", "machine": "a machine"}
                figures = {"asked_m": error, "samples_max_m": error * (1 + i / 20), "surface_max_m": 2 * error, "rms_m": error / 3,
                           "bytes_per_sample": (1 + i) / error, "seconds": error, "decode_seconds": 1e-3, "command": "x"}
                if series.kind != "raster":
                    figures |= {"vertices": 1000 + i, "peak_rss_bytes": 10**8}
                yield {"kind": "level", **common, **figures}
                if series.kind == "tree":
                    drawn = {"frame_seconds": 0.01 * error, "view_peak_rss_bytes": 10**8, "max_error_px": 10 / error}
                    yield {"kind": "frame", **common, **drawn, "samples_max_m": error, "rms_m": error / 3}
                    yield {"kind": "view", **common, **drawn, "pixel_error": error / 10}
                    yield {"kind": "size", **common, "samples": 10**5 * error, "wall_s": error, "cpu_seconds": 2 * error,
                           "tree_bytes": 10**4 * error, "peak_rss_bytes": 10**8}


class Drawing(Folder):
    def test_draws_every_chart_and_the_page_from_a_kept_file(self):
        kept = record.write(self.folder / "results.jsonl", list(canned_records()))
        self.assertEqual(memo.read_lines(self.folder / "results.jsonl"), kept)
        files = draw.charts(CHARTS.values(), kept, self.folder)
        self.assertEqual([f.name for f in files], [c.file for c in CHARTS.values()])
        for chart, file in zip(CHARTS.values(), files):
            text = " ".join(ElementTree.parse(file).getroot().itertext())
            for shown in (chart.title, *(("moon", "rainier") if chart.terrain is None else ()), "tintree best", *(a.label for p in chart.panels for a in (p.x, p.y))):
                self.assertIn(shown, text, file.name)
        everyone = " ".join(ElementTree.parse(self.folder / "bytes.svg").getroot().itertext())
        self.assertTrue(all(s.name in everyone for s in SERIES))
        page_text = page.write(self.folder, kept).read_text()
        self.assertTrue(all(f"]({c.file})" in page_text for c in CHARTS.values()))
        self.assertIn("| delatin |", page_text)

    def test_the_same_figures_give_the_same_bytes(self):
        drawn = [[f.read_bytes() for f in draw.charts([CHARTS["bytes"]], list(canned_records()), self.folder)] for _ in range(2)]
        self.assertEqual(drawn[0], drawn[1])

    def test_leaves_out_charts_without_figures(self):
        levels = [r for r in canned_records() if r["kind"] == "level"]
        names = [f.stem for f in draw.charts(CHARTS.values(), levels, self.folder)]
        self.assertNotIn("screen", names)
        self.assertIn("memory", names)

    def test_methods_are_told_apart(self):
        self.assertEqual(len({s.color.lower() for s in SERIES}), len(SERIES))
        self.assertEqual(len({s.marker for s in SERIES}), len(SERIES))
        self.assertEqual(len({s.name for s in SERIES}), len(SERIES))


class Memory(unittest.TestCase):
    def test_of_a_program_leaves_out_that_of_its_parent(self):
        ours = bytearray(300 << 20)
        for i in range(0, len(ours), 4096):
            ours[i] = 1
        code = "import time; b = bytearray(100 << 20)\nfor i in range(0, len(b), 4096): b[i] = 1\ntime.sleep(0.2)"
        cost = programs.run(sys.executable, "-c", code)
        self.assertGreater(cost.peak_rss_bytes, 100 << 20)
        self.assertLess(cost.peak_rss_bytes, 160 << 20)


if __name__ == "__main__":
    unittest.main()
