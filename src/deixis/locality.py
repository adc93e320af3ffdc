"""Locality: pairs worked on block by block, so that what a block reads and writes stays in the cache."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import numpy as np

from deixis.boxes import Boxes
from deixis.frames import Index
from deixis.parallel import WORKERS, share

Rows = slice | Index
"""Rows of a table: a stretch of it, or rows here and there."""

_BLOCK: Final = 8_192
"""Pairs worked on at once, at most: their intermediate arrays stay in the cache."""

_SPREAD: Final = 16_384
"""With more things than that, the table of boxes does not stay in the cache, so neighbours go together."""


def runs(first: Index, size: Index) -> Index:
    """Return the integers of several runs, one run after the other.

    >>> runs(np.array([5, 0]), np.array([2, 3])).tolist()
    [5, 6, 0, 1, 2]
    """
    ends = np.cumsum(size)
    total = int(ends[-1]) if len(ends) else 0
    return np.arange(total) + np.repeat(first - ends + size, size)


class Neighbourhood:
    """Things in an order in which neighbours in space stand together, for walking through their pairs.

    Parameters
    ----------
    boxes : Boxes
        n things.
    """

    def __init__(self, boxes: Boxes) -> None:
        self._count = len(boxes)
        self._spread = self._count > _SPREAD
        if self._spread:
            self._order = boxes.along_strips
            self._rank = np.empty_like(self._order)
            self._rank[self._order] = np.arange(self._count)

    def table(self, boxes: Boxes) -> Callable[[Index], Boxes]:
        """Return what gathers boxes of these things by their positions in the scene."""
        if not self._spread:
            return boxes.take
        sorted_boxes, rank = boxes.take(self._order), self._rank
        return lambda index: sorted_boxes.take(rank[index])

    def for_blocks(self, figure: Index, work: Callable[[Rows], None]) -> None:
        """Do the work for all pairs with these figures, on all processors: each row once, in some block.

        Blocks are of neighbours where the pairs are sorted by figure, as tables of pairs are.
        """
        count = len(figure)
        # As many blocks as processors, or a multiple, so that all are done at the same time.
        rounds = -(-count // (WORKERS * _BLOCK))
        size = max(-(-count // max(rounds * WORKERS, 1)), _BLOCK // 2)
        blocks = [(start, min(start + size, count)) for start in range(0, count, size)]
        if not self._spread or len(blocks) <= WORKERS or (figure[1:] < figure[:-1]).any():
            share(lambda block: work(slice(*block)), blocks)
            return
        pairs = np.bincount(figure, minlength=self._count)
        first = (np.cumsum(pairs) - pairs)[self._order]
        pairs = pairs[self._order]
        ends = np.cumsum(pairs)

        def rows(start: int, stop: int) -> Index:
            some = slice(int(np.searchsorted(ends, start, "right")), int(np.searchsorted(ends, stop)) + 1)
            begins = ends[some] - pairs[some]
            skipped = np.maximum(start - begins, 0)
            return runs(first[some] + skipped, np.minimum(ends[some], stop) - begins - skipped)

        share(lambda block: work(rows(*block)), blocks)
