"""Results that outlive a run: JSON lines, found again by a key that names all they depend on."""
import hashlib
import json


def digest(*parts):
    """Of texts, numbers, paths' contents (pathlib) and bytes."""
    sum_ = hashlib.sha256()
    for part in parts:
        data = part if isinstance(part, bytes) else part.read_bytes() if hasattr(part, "read_bytes") else repr(part).encode()
        sum_.update(len(data).to_bytes(8, "little") + data)
    return sum_.hexdigest()[:24]


class Memo:
    def __init__(self, path):
        self.path = path
        self.records = {}
        for line in path.read_text().splitlines() if path.exists() else []:
            try:
                record = json.loads(line)
            except json.JSONDecodeError:
                continue  # the last line of a run that was killed
            self.records[record["key"]] = record

    def get(self, key):
        return self.records.get(key)

    def put(self, key, figures):
        record = {"key": key, **figures}
        self.path.parent.mkdir(parents=True, exist_ok=True)
        whole = not self.path.exists() or self.path.read_bytes()[-1:] in (b"\n", b"")
        with self.path.open("a") as file:
            file.write(("" if whole else "\n") + json.dumps(record) + "\n")
        self.records[key] = record
        return record
