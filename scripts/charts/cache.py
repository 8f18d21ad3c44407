"""Measurements kept as JSON lines under keys that name program, input and options."""
import hashlib
import json
from functools import lru_cache
from pathlib import Path


@lru_cache
def file_digest(path):
    return hashlib.sha256(Path(path).read_bytes()).hexdigest()


def key(programs, inputs, **what):
    """Changes with the bytes of any program or input and with anything said in `what`; not with where the files lie.
    A program may also be the name and version of a library."""
    parts = {"programs": [p if isinstance(p, str) else file_digest(p) for p in programs], "inputs": [file_digest(p) for p in inputs], **what}
    return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()[:20]


def read_lines(path):
    """The records of a file; a last line that was cut off by a stop is left out."""
    records = []
    if Path(path).exists():
        for line in Path(path).read_text().splitlines():
            try:
                records.append(json.loads(line))
            except json.JSONDecodeError:
                continue
    return records


class Cache:
    def __init__(self, path):
        self.path = Path(path)
        self.records = {r["key"]: r for r in read_lines(path)}

    def get(self, key):
        return self.records.get(key)

    def add(self, record):
        self.path.parent.mkdir(parents=True, exist_ok=True)
        with self.path.open("a+b") as file:
            if file.tell() > 0:
                file.seek(-1, 2)
                if file.read(1) != b"\n":  # a line that was cut off
                    file.write(b"\n")
            file.write(json.dumps(record).encode() + b"\n")
        self.records[record["key"]] = record
