"""x[k+1] = gain[k] x[k] + push[k] for many modes and many pushes at once: by numba where it is there, else by blocks."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np

from network.declare import Array


def recur(gain: Array, push: Array, start: Array) -> tuple[Array, Array]:
    """All x before each step (K, pushes, n), and the last one (pushes, n).

    gain: (K, n); push: (K, pushes, n), overwritten; start: (pushes, n).
    """
    fast = _compiled()
    if fast is not None and not np.iscomplexobj(push) and not np.iscomplexobj(gain):
        end = np.ascontiguousarray(start, float)
        fast(np.ascontiguousarray(gain), push, end)
        return push, end
    return _by_blocks(gain, push, start)


@cache
def _compiled() -> Callable[[Array, Array, Array], None] | None:
    try:
        from numba import njit
    except ImportError:
        return None

    @njit(cache=True, fastmath=False)  # type: ignore[misc, untyped-decorator]
    def loop(gain: Array, push: Array, x: Array) -> None:
        K, P, n = push.shape
        for k in range(K):
            for p in range(P):
                for i in range(n):
                    now = x[p, i]
                    x[p, i] = gain[k, i] * now + push[k, p, i]
                    push[k, p, i] = now

    return loop  # type: ignore[no-any-return]


def _by_blocks(gain: Array, push: Array, start: Array) -> tuple[Array, Array]:
    """√K steps side by side, so that the interpreter takes 2√K steps and not K."""
    K, P, n = push.shape
    size = max(1, int(np.sqrt(K)))
    blocks = -(-K // size)
    pad = blocks * size - K
    g = np.concatenate([gain, np.ones((pad, n), gain.dtype)]).reshape(blocks, size, 1, n)
    f = np.concatenate([push, np.zeros((pad, P, n), push.dtype)]).reshape(blocks, size, P, n)
    running, carried = np.ones((blocks, 1, n), g.dtype), np.zeros((blocks, P, n), f.dtype)
    product, total = np.empty_like(g), np.empty_like(f)
    for i in range(size):
        product[:, i], total[:, i] = running, carried
        running, carried = running * g[:, i], carried * g[:, i] + f[:, i]
    x, heads = start.astype(f.dtype), np.empty((blocks, P, n), f.dtype)
    for b in range(blocks):
        heads[b] = x
        x = running[b] * x + carried[b]
    total += product * heads[:, None]
    return total.reshape(-1, P, n)[:K], x
