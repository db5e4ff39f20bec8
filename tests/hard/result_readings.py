"""What the tests read off results."""

import numpy as np

from runtime.results.result import Result


def changes(run: Result, name: str, what: str) -> np.ndarray:
    """Instants of an effect's events of one kind."""
    return np.array(
        [e.time for e in run.events if e.name.startswith(f"{name}:") and e.what == what]
    )


def held(run: Result, condition: str) -> np.ndarray:
    """Where the function of a condition stays at zero."""
    return run.mode(condition) == 2


def work(run: Result) -> np.ndarray:
    """Work of all sources up to each instant, by Simpson's rule over two samples each; (k+1)/2."""
    power = run.data["power"].sum("source").values
    h = np.diff(run.t)
    pair = (h[::2] + h[1::2]) / 6.0 * (power[:-2:2] + 4.0 * power[1::2] + power[2::2])
    return np.concatenate([[0.0], np.cumsum(pair)])
