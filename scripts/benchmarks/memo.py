"""Measurements that outlive a run: JSON lines, found again by a key that names all they depend on."""
import hashlib
import json
from functools import lru_cache
from pathlib import Path


def digest(*parts):
    """A key of texts, numbers, paths' contents (pathlib) and bytes, in this order."""
    sum_ = hashlib.sha256()
    for part in parts:
        data = part if isinstance(part, bytes) else part.read_bytes() if hasattr(part, "read_bytes") else repr(part).encode()
        sum_.update(len(data).to_bytes(8, "little") + data)
    return sum_.hexdigest()[:24]


@lru_cache
def file_digest(path):
    return hashlib.sha256(Path(path).read_bytes()).hexdigest()


def key(programs, inputs, **what):
    """A key that changes with the bytes of any program or input and with anything said in `what`; not with where the
    files lie. A program may also be the name and version of a library."""
    parts = {"programs": [p if isinstance(p, str) else file_digest(p) for p in programs], "inputs": [file_digest(p) for p in inputs], **what}
    return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()[:20]


def read_lines(path):
    """The records of a file, none where there is none; a last line that was cut off by a stop is left out."""
    records = []
    for line in Path(path).read_text().splitlines() if Path(path).exists() else []:
        try:
            records.append(json.loads(line))
        except json.JSONDecodeError:
            continue
    return records


class Memo:
    """The latest record of each key in a file. Every record is in the file as soon as it is put."""

    def __init__(self, path):
        self.path = Path(path)
        self.records = {r["key"]: r for r in read_lines(path)}

    def get(self, key):
        return self.records.get(key)

    def put(self, key, figures):
        record = {"key": key, **figures}
        self.path.parent.mkdir(parents=True, exist_ok=True)
        with self.path.open("a+b") as file:
            if file.tell() > 0:
                file.seek(-1, 2)
                if file.read(1) != b"\n":  # a line that was cut off
                    file.write(b"\n")
            file.write(json.dumps(record).encode() + b"\n")
        self.records[key] = record
        return record
