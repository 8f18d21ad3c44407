"""By what factor one method's figures exceed another's at the same error."""
import math


SLACK = 1.02  # by which errors count as the same


def _at(points, x):
    """y of the broken line through `points` in logarithms, or None beyond its ends."""
    if points and points[0][0] / SLACK <= x <= points[-1][0] * SLACK:
        x = min(max(x, points[0][0]), points[-1][0])
    for (x0, y0), (x1, y1) in zip(points, points[1:]):
        if x0 <= x <= x1 and x0 < x1:
            share = math.log(x / x0) / math.log(x1 / x0)
            return y0 * (y1 / y0) ** share
    return None


def factor(points, base):
    """The geometric mean over those of `points` whose x lies within `base`, or None; both by x."""
    logs = [math.log(y / there) for x, y in points if (there := _at(base, x)) is not None]
    return math.exp(sum(logs) / len(logs)) if logs else None
