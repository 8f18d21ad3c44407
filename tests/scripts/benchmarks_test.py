"""What scripts/benchmarks computes and prints, without running what it measures.

usage: benchmarks_test.py
"""
import math
import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "scripts" / "benchmarks"))

import atlas_page  # noqa: E402
import raster_coders  # noqa: E402
import scene  # noqa: E402
import terrains  # noqa: E402
from fitting import largest_within  # noqa: E402
from memo import Memo, digest  # noqa: E402
from programs import Failed, run  # noqa: E402


def row(surface=1.0, samples=1.0, **more):
    return {"surface": surface, "samples": samples, "uncovered": 0, "filled": 0, "folded": 0, "audit": "", "vertices": 7,
            "seconds": 0.5, "error_m": 2, **more}  # fmt: skip


class MemoTest(unittest.TestCase):
    def test_finds_again_what_an_interrupted_run_had(self):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "memo.jsonl"
            Memo(path).put("a", {"n": 1})
            with path.open("a") as file:
                file.write('{"key": "b", "n"')  # killed while it wrote
            memo = Memo(path)
            self.assertEqual((memo.get("a")["n"], memo.get("b")), (1, None))
            memo.put("b", {"n": 2})
            self.assertEqual(Memo(path).get("b")["n"], 2)

    def test_digest_sees_contents_and_where_parts_end(self):
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "tool"
            file.write_text("one")
            before = digest("x", file)
            file.write_text("two")
            self.assertNotEqual(before, digest("x", file))
        self.assertNotEqual(digest(b"ab", b"c"), digest(b"a", b"bc"))


class RunTest(unittest.TestCase):
    def outcome(self, script, **options):
        with self.assertRaises(Failed) as caught:
            run(sys.executable, "-c", script, **options)
        return caught.exception.outcome, caught.exception.message

    def test_says_how_a_program_ended(self):
        self.assertEqual(run("/bin/echo", "hello").output, "hello\n")
        self.assertEqual(self.outcome("import sys; sys.exit('no squares here')"), ("refused", "no squares here"))
        self.assertEqual(self.outcome("import os; os.abort()"), ("crashed", "SIGABRT"))
        self.assertEqual(self.outcome("while True: pass", limit_s=1)[0], "time limit")


class LatticeTest(unittest.TestCase):
    def test_rounding_and_spare_steps_stay_within_the_error(self):
        random = np.random.default_rng(5)
        for span_m, error_m in ((3.0, 1.0), (9e4, 11.0), (6e4, 0.7), (1.2e5, 1.0), (1e-6, 1e-9), (5e-5, 5e-6)):
            heights = 1e3 + span_m * random.random((40, 30))
            steps = raster_coders.lattice(heights, error_m)
            worst = np.abs(steps.numbers * steps.step_m + steps.base_m - heights).max() + steps.spare_steps(error_m) * steps.step_m
            self.assertLess(worst, error_m * (1 + 1e-6), (span_m, error_m))
            self.assertLess(steps.numbers.max(), 2**16)

    def test_whole_metres_stay_what_they_are(self):
        steps = raster_coders.lattice(np.array([[-5, 3], [9, 0]]), 2.7)
        self.assertEqual((steps.numbers.tolist(), steps.step_m, steps.spare_steps(2.7)), ([[-5, 3], [9, 0]], 1.0, 2))

    def test_refuses_what_sixteen_bits_cannot_hold(self):
        with self.assertRaises(Failed):
            raster_coders.lattice(np.array([[0.5, 1e6]]), 1.0)


class FittingTest(unittest.TestCase):
    def test_bounds_the_error_that_is_named(self):
        best = largest_within(lambda p: {"samples_max_m": 100 * p, "rms_m": p**1.5}, 8, 1, 0.01, 1000, 20, key="rms_m")
        self.assertLessEqual(best["rms_m"], 8)
        self.assertGreater(best["rms_m"], 7)


class PageTest(unittest.TestCase):
    def test_a_cell_says_by_how_much_and_where(self):
        self.assertEqual(atlas_page.cell(row(0.4)), "0.40")
        self.assertEqual(atlas_page.cell(row(1 + 1e-12)), "1.00")
        self.assertEqual(atlas_page.cell(row(112.5, 0.9)), "**112** <sup>s</sup>")
        self.assertEqual(atlas_page.cell(row(3, 3, filled=2, folded=1)), "**3** <sup>hf</sup>")
        self.assertEqual(atlas_page.cell({"outcome": "crashed", "message": "SIGSEGV"}), "*crashed*")

    def test_ours_may_refuse_but_not_break_its_word(self):
        for broken in (row(1.001), row(uncovered=1), row(folded=1), row(filled=1), row(audit="1 violation"), {"outcome": "crashed"}):
            self.assertTrue(atlas_page.breach_of_ours("tintree best", broken), broken)
            self.assertFalse(atlas_page.breach_of_ours("delatin", broken), broken)
        self.assertFalse(atlas_page.breach_of_ours("tintree best", row()))
        self.assertFalse(atlas_page.breach_of_ours("tintree best", {"outcome": "refused", "message": "no surface"}))

    def test_the_page_counts_what_holds(self):
        kinds = {t: terrains.Terrain(t, "planes", "made up", 9, 9, 2) for t in ("a", "b", "c")}
        rows = {name: row() for name in atlas_page.NAMES}
        atlas = {
            kinds["a"]: {**rows, "delatin": row(5, 1)},
            kinds["b"]: {**rows, "delatin": row(7, 2)},
            kinds["c"]: {**rows, "delatin": {"outcome": "time limit", "message": "not done", "error_m": 2}},
        }
        line = next(l for l in atlas_page.overview(atlas).splitlines() if l.startswith("| delatin"))
        self.assertEqual([c.strip() for c in line.split("|")[2:7]], ["0", "1", "1", "1 time limit", "**7** b"])
        page = atlas_page.page(atlas, "images")
        self.assertNotIn("{", page.replace("{z", ""))
        self.assertIn('delatin on c: time limit, "not done"', page)

    def test_messages_lose_the_machine_and_stay_short(self):
        self.assertEqual(atlas_page.shortened("tool: /somewhere/else/dem.tif: is | odd"), "tool: dem.tif: is / odd")
        self.assertLessEqual(len(atlas_page.shortened("long " * 100)), 160)


class SceneTest(unittest.TestCase):
    def test_the_trees_levels_are_the_ladder(self):
        for levels in (1, 2, 3, 4):
            rungs = sorted(e * 2**k for e in scene.ladder_errors(10.0, levels) for k in range(levels))
            for i, rung in enumerate(rungs):
                self.assertAlmostEqual(rung, 10.0 * math.sqrt(2) ** i, 6)
            self.assertGreaterEqual(len(rungs), scene.RUNGS)


unittest.main()
