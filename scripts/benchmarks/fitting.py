"""Finds the parameter at which a rival just keeps within an error."""
import math


def largest_within(make, bound, start, low, high, steps, key="samples_max_m"):
    """The best figures of `make(parameter)` whose `key` is within `bound`, or None.

    The error must grow with the parameter, roughly. Interpolates in logarithms between the parameters known
    to be within and beyond, `steps` times at most, and stops where the bound is used to 2 %.
    """
    best, within, beyond, parameter = None, None, None, start
    for _ in range(steps):
        figures = make(parameter)
        error = figures[key]
        if error <= bound:
            within, best = (parameter, error), figures
            if error > 0.98 * bound:
                break
        else:
            beyond = (parameter, error)
        if parameter >= high and error <= bound or parameter <= low and error > bound:
            break
        parameter = min(high, max(low, _next(parameter, error, bound, within, beyond)))
    return best


def _next(parameter, error, bound, within, beyond):
    if not (within and beyond):
        guess = parameter * (bound / max(error, bound / 64))
        return guess * (1.05 if beyond is None else 0.95)
    a, b = math.log(within[0]), math.log(beyond[0])
    ea, eb = math.log(max(within[1], 1e-9)), math.log(beyond[1])
    share = (math.log(bound) - ea) / (eb - ea) if eb > ea else 0.5
    return math.exp(a + (b - a) * min(0.9, max(0.1, 0.95 * share)))
