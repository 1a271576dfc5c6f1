"""x[k+1] = gain[k] x[k] + push[k] for many modes and pushes at once: by numba where it is there, else few numbers as a
banded system and many by blocks."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
from scipy.linalg.lapack import dtbtrs, ztbtrs

from network.catalogue.declaration.declare import Array

A_STEP = 1000
"""Numbers that a banded system solves while the interpreter takes a step (measured: 300 to 3000)."""


def recur(gain: Array, push: Array, start: Array) -> tuple[Array, Array]:
    """All x before each step (K, pushes, n), and the last one (pushes, n).

    gain: (K, n); push: (K, pushes, n), overwritten; start: (pushes, n).
    """
    fast = compile_recursion()
    if fast is not None and not np.iscomplexobj(push) and not np.iscomplexobj(gain):
        end = np.array(start, float)
        fast(np.ascontiguousarray(gain), push, end)
        return push, end
    steps = 2 * np.sqrt(len(push))
    return (as_banded if 0 < push.size < A_STEP * steps else by_blocks)(gain, push, start)


@cache
def compile_recursion() -> Callable[[Array, Array, Array], None] | None:
    """The recursion as machine code; None without numba."""
    try:
        from numba import njit
    except ImportError:
        return None

    @njit(cache=True, fastmath=False)  # type: ignore[untyped-decorator]
    def loop(gain: Array, push: Array, x: Array) -> None:
        K, P, n = push.shape
        for k in range(K):
            for p in range(P):
                for i in range(n):
                    now = x[p, i]
                    x[p, i] = gain[k, i] * now + push[k, p, i]
                    push[k, p, i] = now

    return loop  # type: ignore[no-any-return]


def as_banded(gain: Array, push: Array, start: Array) -> tuple[Array, Array]:
    """As one system with ones on the diagonal and −gain below it, mode after mode, by LAPACK."""
    (K, P, n), kind = push.shape, np.result_type(gain, push, start)
    bands, right = np.ones((2, n, K + 1), kind), np.empty((P, n, K + 1), kind)
    bands[1, :, :K], bands[1, :, K] = -gain.T, 0.0
    right[:, :, 0], right[:, :, 1:] = start, push.transpose(1, 2, 0)
    solve = ztbtrs if np.iscomplexobj(right) else dtbtrs
    x, _ = solve(bands.reshape(2, -1), right.reshape(P, -1).T, uplo="L", diag="U", overwrite_b=1)
    x = x.T.reshape(P, n, K + 1)
    return np.ascontiguousarray(x[:, :, :K].transpose(2, 0, 1)), x[:, :, K]


def by_blocks(gain: Array, push: Array, start: Array) -> tuple[Array, Array]:
    """√K steps side by side, so that the interpreter takes 2√K steps and not K; the rest one by one."""
    K, P, n = push.shape
    if np.iscomplexobj(gain) and not np.iscomplexobj(push):
        push = push.astype(complex)
    size = max(1, int(np.sqrt(K)))
    blocks = K // size
    g, f = gain[: blocks * size].reshape(blocks, size, 1, n), push[: blocks * size].reshape(blocks, size, P, n)
    carried, passed = np.zeros((blocks, P, n), push.dtype), np.cumprod(g, axis=1)
    for i in range(size):
        now = carried * g[:, i]
        now += f[:, i]
        f[:, i], carried = carried, now
    x = start.astype(push.dtype)
    for b in range(blocks):
        f[b, 0] += x
        f[b, 1:] += passed[b, :-1] * x
        x = passed[b, -1] * x + carried[b]
    for k in range(blocks * size, K):
        now = gain[k] * x + push[k]
        push[k], x = x, now
    return push, x


def chain_blocks(through: Array) -> tuple[Array, Array]:
    """What √K steps in a row make of modes that mix, block by block: of those at the beginning of a block before every
    step (blocks, size, n, n), and after the last (blocks, n, n). through: (K, n, n)."""
    K, n = through.shape[:2]
    size = max(1, int(np.sqrt(K)))
    blocks = K // size
    A, passed = through[: blocks * size].reshape(blocks, size, n, n), np.empty((blocks, size, n, n), through.dtype)
    product = np.broadcast_to(np.eye(n, dtype=through.dtype), (blocks, n, n))
    for i in range(size):
        passed[:, i] = product
        product = product @ A[:, i]
    return passed, product


def recur_coupled(through: Array, push: Array, start: Array, chained: tuple[Array, Array]) -> tuple[Array, Array]:
    """x[k+1] = x[k] through[k] + push[k] where the modes mix, √K steps side by side as in `by_blocks`: all x before
    each step (K, pushes, n), and the last one. through: (K, n, n); push is overwritten; chained: `chain_blocks`."""
    (K, P, n), (passed, product) = push.shape, chained
    blocks, size = passed.shape[:2]
    A, f = through[: blocks * size].reshape(blocks, size, n, n), push[: blocks * size].reshape(blocks, size, P, n)
    carried = np.zeros((blocks, P, n), push.dtype)
    for i in range(size):
        now = carried @ A[:, i]
        now += f[:, i]
        f[:, i], carried = carried, now
    x = start.astype(push.dtype)
    for b in range(blocks):
        f[b] += x @ passed[b]
        x = x @ product[b] + carried[b]
    for k in range(blocks * size, K):
        now = x @ through[k] + push[k]
        push[k], x = x, now
    return push, x
