"""How far a run is, on stderr."""
import sys
import time

LEARNED_S = 20  # of expected work, after which the pace so far says more than the expectation


class Progress:
    def __init__(self, planned, expected):
        """`planned`: pieces of work in all; `expected`: {piece: seconds} of those still to do, in their order."""
        self.expected, self.done, self.passed_s, self.running_s = expected, 0, 0.0, 0.0
        self.begun = time.monotonic()
        print(f"{planned} measurements, {planned - len(expected)} of them done before; about {_duration(sum(expected.values()))}",
              file=sys.stderr, flush=True)

    def begin(self, piece, text):
        self.passed_s += self.running_s
        self.running_s = self.expected[piece]
        self.done += 1
        elapsed_s = time.monotonic() - self.begun
        pace = elapsed_s / self.passed_s if self.passed_s > LEARNED_S else 1.0
        to_go_s = pace * (sum(self.expected.values()) - self.passed_s)
        print(f"[{self.done}/{len(self.expected)}] {text}; {_duration(elapsed_s)} passed, about {_duration(to_go_s)} to go",
              file=sys.stderr, flush=True)


def _duration(seconds):
    return f"{seconds:.0f} s" if seconds < 100 else f"{seconds / 60:.1f} min"
