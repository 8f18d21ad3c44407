"""scripts/bench view: recorded flights through tintree-view. See scripts/bench --help."""
import argparse
import json
import platform
import sys
from pathlib import Path
from statistics import median

import exclusive
import flights
from datasets import DEMS, Raster, crop, whole
from programs import BIN, CACHE, ROOT, cpu_name, run
from results import PATH, Results, number, print_table

SIDES = (1025, 2049, 4097, 8193)
AUTZEN = "autzen_dsm_2ft_raw.tif"
PHOTOS = {AUTZEN: "autzen.jpg"}
EVERY = 20  # frames between those that are compared with the surface
STILLS = 61  # frames of a standing view


def data(args):
    """The Moon, California, Autzen. A quick run takes crops."""
    moon = crop(args.data, "moon", 2049, 2049) if args.quick else whole(args.data, "moon")
    california = crop(args.data, "california") if args.quick else whole(args.data, "california")
    return moon, california, Raster("autzen", args.data / AUTZEN)


def sierra(args):
    """Begin and end of the flight, as shares of California."""
    return ((0.1, 0.1), (0.9, 0.9)) if args.quick else ((0.44, 0.2), (0.56, 0.75))


def fast_flights(args, seconds, suffix=""):
    """Name, raster, error of its leaves in metres, path."""
    moon, california, autzen = data(args)
    yield "high over the Moon", moon, 10, flights.fly(moon, "moon" + suffix, (0.1, 0.5), (0.9, 0.5), 14000, 20000, seconds, -30)
    yield "low through the Sierra", california, 5, flights.fly(
        california, "sierra" + suffix, *sierra(args), 1500, 300, seconds, -5, sway=0.02)
    yield "over Autzen", autzen, 0.3, flights.fly(autzen, "autzen" + suffix, (0.2, 0.9), (0.8, 0.1), 150, 60, seconds, -20)


def slow_flights(args, seconds):
    """So slow that far ground looks the same for many frames; at last one that only turns, 25 degrees to and fro."""
    moon, california, autzen = data(args)
    yield "Moon, 2 km up, 10 m/s", moon, 10, flights.fly(moon, "moon_slow", (0.1, 0.5), (0.9, 0.5), 36, 2000, seconds, -10)
    yield "Sierra, 100 m up, 5 m/s", california, 5, flights.fly(california, "sierra_slow", *sierra(args), 18, 100, seconds, -5)
    # A frame of it is seconds of work.
    yield "Autzen, 60 m up, 1 m/s", autzen, 0.3, flights.fly(
        autzen, "autzen_slow", (0.2, 0.9), (0.8, 0.1), 3.6, 60, seconds / 3, -20)
    yield "Sierra, 100 m up, turning", california, 5, flights.fly(
        california, "sierra_turning", *sierra(args), 1, 100, seconds, -5, sway=1e-9)


def build(raster, error_m):
    tree = CACHE / f"view_{raster.path.stem}_{error_m:g}.tintree"
    if not tree.exists() or tree.stat().st_mtime < (BIN / "tintree-build").stat().st_mtime:
        photo = PHOTOS.get(raster.path.name)
        run(BIN / "tintree-build", raster.path, "-o", tree, "--error", error_m, "--overwrite", "--quiet",
            *(["--ortho", raster.path.with_name(photo)] if photo else []))
    return tree


def fly(args, tree, path, *options):
    figures = CACHE / "view.json"
    cost = run(BIN / "tintree-view", tree, "--headless", args.headless, "--size", args.size, "--flight", path,
               "--json", figures, "--quiet", *options)
    return json.loads(figures.read_text()), cost


def run_flights(results, args):
    width, height = args.size.split("x")
    for name, raster, error_m, path in fast_flights(args, 4 if args.quick else 30):
        tree = build(raster, error_m)
        fly(args, tree, path, "--fps", "5")  # Warms the operating system's cache.
        figures, cost = fly(args, tree, path, "--real-time")
        compared = run(BIN / "bench_view", tree, "--flight", path, "--dem", raster.path, "--headless", args.headless,
                       "--every", EVERY * (4 if args.quick else 1), "--width", width, "--height", height).json()
        frames = figures.pop("frames")
        results.add("view", flight=name, data=raster.name, error_m=error_m, size=args.size, renderer=figures["renderer"],
                    frames=len(frames), median_s=figures["frame_seconds_median"], p99_s=figures["frame_seconds_p99"],
                    worst_s=figures["frame_seconds_worst"], triangles=figures["triangles"] / len(frames),
                    draw_calls=figures["draw_calls"] / len(frames), bytes_read=figures["bytes_read"],
                    cache_hits=figures["cache_hits"], cache_misses=figures["cache_misses"],
                    late_tiles=figures["late_tiles"], late_frames=figures["late_frames"],
                    gpu_bytes=max(f["gpu_bytes"] for f in frames), cache_bytes=max(f["cache_bytes"] for f in frames),
                    cost=compared["cost"], image=compared["image"], occlusion=compared["occlusion"],
                    command=cost.command)
    print_flights(results)


def run_impostors(results, args):
    """Slow flights and fast ones in turn without and with impostors; the less processor time of two. Every 20th frame of
    one more flight with them is compared with the surface."""
    width, height = args.size.split("x")
    seconds = 2 if args.quick else 4
    fast = [f for f in fast_flights(args, seconds, "_short") if f[1].name != "autzen"]
    for name, raster, error_m, path in (*slow_flights(args, seconds), *fast):
        tree = build(raster, error_m)
        ways = {"without": [], "with": []}
        for _ in range(1 if raster.name == "autzen" else 2):
            for way, runs in ways.items():
                figures, cost = fly(args, tree, path, "--fps", "30", *["--impostors"] * (way == "with"))
                frames = figures["frames"]
                runs.append({"cpu_s": cost.cpu_seconds, "triangles": figures["triangles"] + figures["impostor_triangles"],
                             "gpu_bytes": max(f["gpu_bytes"] for f in frames), "frames": len(frames),
                             "shown": sum(f["impostor_tiles"] > 0 for f in frames),
                             "drawing": sum(f["impostor_triangles"] > 0 for f in frames),
                             "frame_s": [f["frame_seconds"] for f in frames]})
        first = next((i for i, f in enumerate(frames) if f["impostor_tiles"] > 0), 0)
        for run_of in (r for runs in ways.values() for r in runs):
            since = sorted(run_of.pop("frame_s")[first:])
            run_of["p99_of_median"] = since[len(since) * 99 // 100] / median(since)
        image = run(BIN / "bench_view", tree, "--impostors", "--flight", path, "--dem", raster.path, "--headless", args.headless,
                    "--every", EVERY, "--width", width, "--height", height).json()
        least = {way: min(runs, key=lambda r: r["cpu_s"]) for way, runs in ways.items()}
        results.add("view_impostors", flight=name, size=args.size, **least, first=first, image=image, command=cost.command)
    print_impostors(results)


def run_sizes(results, args):
    """The runs of all sizes in turn, so that what else goes on hits all of them alike."""
    sides = SIDES[:2] if args.quick else SIDES
    crops = {side: whole(args.data, "moon") if side == 8193 else crop(args.data, "moon", side, side) for side in sides}
    crops[1025] = _corner(args)
    path = flights.look_into_corner(crops[1025])
    trees = {side: build(raster, 10) for side, raster in crops.items()}
    medians = {side: [] for side in sides}
    for _ in range(3):
        for side, tree in trees.items():
            figures, _ = fly(args, tree, path, "--fps", "30")
            medians[side].append(median(f["frame_seconds"] for f in figures["frames"][5:]))
    for side in sides:
        results.add("view_sizes", side=side, samples=side * side, frame_s=min(medians[side]),
                    triangles=figures["frames"][-1]["triangles"], tree_bytes=trees[side].stat().st_size)
    print_sizes(results)


def _corner(args):
    """The Moon's north-west corner; crop() of this size has another place in it."""
    from osgeo import gdal
    path = CACHE / "moon_corner_1025.tif"
    if not path.exists():
        gdal.Translate(str(path), str(args.data / DEMS["moon"]), srcWin=[0, 0, 1025, 1025])
    return Raster("moon corner 1025²", path)


def print_flights(results):
    ms = lambda s: number(1e3 * s, 3)
    rows = [[r["flight"], r["data"], r["frames"], ms(r["median_s"]), ms(r["p99_s"]), ms(r["worst_s"]),
             f"{r['p99_s'] / r['median_s']:.2f}", number(round(r["triangles"])), number(r["draw_calls"], 3),
             number(r["bytes_read"]), r["cache_hits"], r["cache_misses"], r["late_tiles"], r["late_frames"]]
            for r in results.of("view")]
    print_table("Flights at real time (the operating system's cache is warm)",
                ["flight", "data", "frames", "median ms", "p99 ms", "worst ms", "p99/median", "triangles/frame",
                 "calls/frame", "bytes read", "hits", "misses", "late tiles", "late frames"], rows)
    rows = [[r["flight"], r["image"]["views"], r["image"]["crack_px"], number(r["image"]["shift_max_px"], 3),
             number(r["image"]["drawn_max_px"], 3), number(r["image"]["limit_px"], 3), r["image"]["violations"],
             ms(r["cost"]["scene_seconds"]), ms(r["cost"]["static_seconds"]), f"{r['cost']['ratio']:.3f}"]
            for r in results.of("view")]
    print_table(f"Every {EVERY}th frame against the surface, and against one static buffer of its triangles",
                ["flight", "views", "crack px", "shift px", "drawn px", "allowed px", "violations", "frame ms",
                 "static ms", "frame/static"], rows)
    rows = []
    for r in results.of("view"):
        off, pays, always = (r["occlusion"][way] for way in ("off", "where_it_pays", "always"))
        rows.append([r["flight"], number(off["triangles"], 4), number(pays["triangles"], 4), number(always["hidden"], 3),
                     ms(off["cpu_seconds"])] + [f"{way['cpu_seconds'] / off['cpu_seconds']:.3f}" for way in (pays, always)])
        rows[-1] += [ms(way["choosing_cpu_seconds"]) for way in (off, pays, always)]
    print_table("Looking for what nearer ground hides: processor time of a frame, all threads; and of choosing its tiles alone",
                ["flight", "triangles without", "where it pays", "parts hidden", "ms without", "where it pays", "always",
                 "choosing ms without", "where it pays", "always"], rows)


def print_impostors(results):
    rows = []
    for r in results.of("view_impostors"):
        without, ours, image = r["without"], r["with"], r["image"]
        rows.append([r["flight"], ours["frames"], number(without["cpu_s"], 3), number(ours["cpu_s"], 3),
                     f"{ours['cpu_s'] / without['cpu_s']:.3f}", number(without["triangles"]), number(ours["triangles"]),
                     r["first"], ours["drawing"], ours["shown"], f"{without['p99_of_median']:.2f}", f"{ours['p99_of_median']:.2f}",
                     number(round(ours["gpu_bytes"] / 1e6)), f"{image['with_impostor']} of {image['views']}", image["crack_px"],
                     number(image["drawn_max_px"], 3), number(image["limit_px"], 3), image["violations"]])
    print_table("Impostors: processor seconds of whole flights, and every 20th frame against the surface",
                ["flight", "frames", "cpu s without", "with", "with/without", "triangles without", "with, pictures' too",
                 "first shown in frame", "frames that draw some of one", "frames with one", "p99/median since then without", "with", "graphics MB", "compared views with one",
                 "crack px", "drawn px", "allowed px", "violations"], rows)


def print_sizes(results):
    records = results.of("view_sizes")
    rows = [[f"{r['side']}²", number(r["tree_bytes"]), number(r["triangles"]), number(1e3 * r["frame_s"], 4),
             f"{r['frame_s'] / records[0]['frame_s']:.3f}"] for r in records]
    print_table("The same view of the Moon in data sets of four sizes", ["data", "tree bytes", "triangles", "frame ms", "of the first"], rows)


def arguments():
    parser = argparse.ArgumentParser(prog="scripts/bench view", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="crops and short flights: minutes")
    parser.add_argument("--only", choices=("flights", "impostors", "sizes"), action="append", help="this table; may be given again")
    parser.add_argument("--headless", choices=("osmesa", "egl"), default="osmesa", help="software, or a graphics card")
    parser.add_argument("--size", default="1280x720", help="WIDTHxHEIGHT of the pictures")
    parser.add_argument("--data", default=ROOT.parent / "shared" / "data", type=Path, help="folder of the DEMs")
    parser.add_argument("--show", metavar="RUN", help="measure nothing; print the tables of an earlier run")
    return parser.parse_args()


def main():
    args = arguments()
    if args.show:
        for show in (print_flights, print_impostors, print_sizes):
            show(Results(args.show))
        return
    lock = exclusive.begin(args.data)  # held until the end
    results = Results()
    print(f"## scripts/bench view, {results.run}, {cpu_name()}, {platform.system()} {platform.machine()}")
    for table in args.only or ("flights", "impostors", "sizes"):
        {"flights": run_flights, "impostors": run_impostors, "sizes": run_sizes}[table](results, args)
        sys.stdout.flush()
    print(f"\nEvery figure with the command that made it: {PATH.relative_to(ROOT)}, run {results.run}")


main()
