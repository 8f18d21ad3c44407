"""scripts/bench build: tintree-build beside what else one could use. See scripts/bench --help."""
import argparse
import platform
import sys
from pathlib import Path

import exclusive
import memory
import quality
import speed
import trees
from memo import digest
from programs import BIN, ROOT, cpu_name
from results import PATH, Results, print_times

TABLES = ("quality", "trees", "speed", "memory")


def arguments():
    parser = argparse.ArgumentParser(prog="scripts/bench build", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="small windows, few errors, no slow rivals: minutes")
    parser.add_argument("--large", action="store_true", help="speed and memory up to 537 M samples too")
    parser.add_argument("--only", choices=TABLES, action="append", help="this table; may be given again")
    parser.add_argument("--data", default=ROOT.parent / "shared" / "data", type=Path, help="folder of the DEMs")
    parser.add_argument("--resume", metavar="RUN", help="go on with a run that was cut short: keep the rows it has measured")
    parser.add_argument("--show", metavar="RUN", help="measure nothing; print the tables of an earlier run (its start, 2026-01-31T12:00:00)")
    return parser.parse_args()


def show(run):
    results = Results(run)
    for table, module in (("quality", quality), ("trees", trees), ("speed", speed), ("memory", memory)):
        if results.of(table):
            module.print_tables(results)


def check_resumable(results):
    programs = {record.get("program") for record in results.records()}
    if programs != {results.common["program"]}:
        sys.exit(f"scripts/bench: --resume {results.run}: tintree-build has changed since; begin anew")


def main():
    args = arguments()
    if args.show:
        show(args.show)
        return
    lock = exclusive.begin(args.data)  # held until the end
    results = Results(args.resume, program=digest(BIN / "tintree-build"))
    if args.resume:
        check_resumable(results)
    print(f"## scripts/bench build, {results.run}, {cpu_name()}, {platform.system()} {platform.machine()}")
    runs = {
        "quality": lambda: quality.run(results, args.data, args.quick),
        "trees": lambda: trees.run(results, args.data, args.quick),
        "speed": lambda: speed.run(results, args.data, args.quick, args.large),
        "memory": lambda: memory.run(results, args.data, args.quick, args.large),
    }
    for table in args.only or TABLES:
        runs[table]()
        sys.stdout.flush()
        print_times(results, args.only or TABLES)
    print(f"\nEvery figure with the command that made it: {PATH.relative_to(ROOT)}, run {results.run}")


main()
