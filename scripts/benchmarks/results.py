"""Every measurement is one JSON line in build/bench/results.jsonl; the tables are printed from those lines."""
import json
import sys
import time

from memo import read_lines
from programs import BENCH, ROOT

PATH = BENCH / "results.jsonl"


class Results:
    def __init__(self, run=None, **common):
        """The records of one run, named by its start; a new one by default. Ends the program where there is no such run.
        `common` goes into all that are added."""
        self.run = run or time.strftime("%Y-%m-%dT%H:%M:%S")
        self.common = common
        runs = sorted({r["run"] for r in read_lines(PATH)}) if run else []
        if run and run not in runs:
            known = f"; there are {' '.join(runs)}" if runs else ", nor any other: scripts/bench has not been run here"
            sys.exit(f"scripts/bench: {PATH.relative_to(ROOT)} has no run {run}{known}")

    def add(self, table, **figures):
        record = {"run": self.run, "table": table, **self.common, **figures}
        with PATH.open("a") as file:
            file.write(json.dumps(record) + "\n")
        shown = {k: v for k, v in figures.items() if k not in ("command", "levels")}
        print("  " + json.dumps(shown), file=sys.stderr, flush=True)
        return record

    def once(self, table, make, **row):
        """The run's record of a row, named by its data, method and so on. What the run has not measured yet is, by
        `make()`, which returns the figures; the time that took is one of them."""
        for record in self.of(table):
            if all(record.get(key) == value for key, value in row.items()):
                return record
        begun = time.monotonic()
        figures = make()
        return self.add(table, **{**row, **figures}, took_s=round(time.monotonic() - begun, 1))

    def of(self, table):
        return [r for r in self.records() if r["table"] == table]

    def records(self):
        return [r for r in read_lines(PATH) if r["run"] == self.run]


def print_times(results, tables, slowest=8):
    """On stderr: what each table took, and the rows that took longest."""
    records = [r for r in results.records() if "took_s" in r]
    minutes = [f"{t} {sum(r['took_s'] for r in records if r['table'] == t) / 60:.1f}" for t in tables]
    print(f"minutes: {', '.join(minutes)}; the slowest rows:", file=sys.stderr)
    for r in sorted(records, key=lambda r: -r["took_s"])[:slowest]:
        print(f"  {r['took_s']:.0f} s: {r['table']}, {r['data']}, {r['method']}", file=sys.stderr)


def print_table(title, header, rows):
    print(f"\n### {title}\n")
    print("| " + " | ".join(header) + " |")
    print("|" + "---|" * len(header))
    for row in rows:
        print("| " + " | ".join("" if cell is None else str(cell) for cell in row) + " |")


def number(value, digits=4):
    """`digits` significant digits, thousands apart."""
    if value is None:
        return None
    if isinstance(value, int) or abs(value) >= 10**digits:
        return f"{round(value):,}".replace(",", " ")
    return f"{value:.{digits}g}"
