"""Products of columns with those that are 0, as arrays, and from such arrays."""

import numpy as np

from hbench.reconcile.evidence.products import Block, ColumnProducts


def column_products(dense: np.ndarray) -> ColumnProducts:
    """Return products (p, g, q, q) as blocks of the groups that the same columns change."""
    nonzero = np.einsum("pgjj->gj", dense) > 0
    blocks = []
    for pattern in np.unique(nonzero[nonzero.any(axis=1)], axis=0):
        groups = np.flatnonzero((nonzero == pattern).all(axis=1))
        columns = np.flatnonzero(pattern)
        values = dense[:, groups[:, None, None], columns[:, None], columns]
        blocks.append(Block(groups, columns, values))
    return ColumnProducts(tuple(blocks), dense.shape[:3])


def all_products(products: ColumnProducts) -> np.ndarray:
    """Return all products (p, g, q, q)."""
    _, groups, columns = products.shape
    return products.dense(np.arange(groups), np.arange(columns))
