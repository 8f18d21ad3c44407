"""Every measurement is one JSON line in build/bench/results.jsonl; the tables are printed from those lines."""
import json
import sys
import time

from programs import BENCH

PATH = BENCH / "results.jsonl"


class Results:
    def __init__(self, run=None):
        """The records of one run, named by its start; a new one by default."""
        self.run = run or time.strftime("%Y-%m-%dT%H:%M:%S")

    def add(self, table, **figures):
        record = {"run": self.run, "table": table, **figures}
        with PATH.open("a") as file:
            file.write(json.dumps(record) + "\n")
        shown = {k: v for k, v in figures.items() if k not in ("command", "levels")}
        print("  " + json.dumps(shown), file=sys.stderr, flush=True)
        return record

    def of(self, table):
        with PATH.open() as file:
            records = [json.loads(line) for line in file]
        return [r for r in records if r["run"] == self.run and r["table"] == table]


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
