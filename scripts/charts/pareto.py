"""The points that no other beats."""


def front(points):
    """Those (x, y) for which no other point is as small in both and smaller in one; by x, each once."""
    out = []
    for x, y in sorted(set(points)):
        if not out or y < out[-1][1]:
            out.append((x, y))
    return out
