"""An orthonormal basis of many columns that nearly depend on each other."""

from __future__ import annotations

import numpy as np

from network.catalogue.declaration.declare import Array

KEPT, KEPT_AGAIN = 1e-14, 1e-8
"""Of the largest eigenvalue of the Gram matrix, in the first and in the second pass: smaller ones are rounding."""


def orthonormalise(columns: Array) -> tuple[Array, Array]:
    """An orthonormal basis of the columns, by their Gram matrix, and the columns in it. A second pass finds what the
    first lost in rounding. The columns are used up, for they are what fills the memory."""
    first = _directions(columns, KEPT)
    along = first.T @ columns
    columns -= first @ along
    size = np.linalg.norm(columns, axis=0)
    lost = size > 1e-9
    if not lost.any():
        return first, along
    more = _directions(columns[:, lost] / size[lost], KEPT_AGAIN)
    more -= first @ (first.T @ more)
    V = _even_out(np.hstack([first, more]))
    return V, (V.T @ first) @ along + V.T @ columns


def _even_out(V: Array) -> Array:
    """Columns that are nearly orthonormal, made so (Löwdin); what is no direction of its own is left out."""
    size, U = np.linalg.eigh(V.T @ V)
    return np.asarray(V @ (U[:, size > 0.5] / np.sqrt(size[size > 0.5])))


def _directions(columns: Array, kept: float) -> Array:
    size, U = np.linalg.eigh(columns.T @ columns)
    keep = size > kept * size[-1]
    return np.asarray(columns @ (U[:, keep] / np.sqrt(size[keep])))
