"""Memory of large arrays that is used again.

The system clears fresh memory, which takes longer than a step of arithmetic on it: of a
large contact's relaxation it was a third of the time.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

# Bytes from where on it is worth it.
_LARGE = 1 << 20
# Sizes of arrays whose memory is kept: numbers of both precisions and masks, of a
# window and of a box within it.
_SIZES = 6

# Memory that is free, by its size; the size that was asked for last is the last.
_SPARE: dict[int, list[np.ndarray]] = {}
# What goes on that recycles.
_USERS: list[object] = []


@contextmanager
def recycled() -> Iterator[None]:
    """Let `empty` and `zeros` use memory again, of any thread; free it at the end."""
    _USERS.append(None)
    try:
        yield
    finally:
        _USERS.pop()
        if not _USERS:
            _SPARE.clear()


class _Lease:
    """Memory of an array until the array is gone, and all views of it."""

    def __init__(self, memory: np.ndarray) -> None:
        self._memory = memory
        self.__array_interface__ = memory.__array_interface__

    def __del__(self) -> None:
        spare = _SPARE.get(self._memory.size)
        if spare is not None:
            spare.append(self._memory)


def empty(shape: int | tuple[int, ...], dtype: Any = float) -> np.ndarray:
    """Array that holds anything; when `recycled`, in memory that was used before.

    Parameters
    ----------
    shape : int or tuple of int
    dtype : dtype

    Returns
    -------
    ndarray
    """
    size = math.prod(np.atleast_1d(shape).tolist()) * np.dtype(dtype).itemsize
    if size < _LARGE or not _USERS:
        return np.empty(shape, dtype)
    spare = _SPARE.pop(size, [])
    _SPARE[size] = spare
    for oldest in list(_SPARE)[:-_SIZES]:
        _SPARE.pop(oldest, None)
    try:
        memory = spare.pop()
    except IndexError:
        memory = np.empty(size, np.uint8)
    return np.asarray(_Lease(memory)).view(dtype).reshape(shape)


def zeros(shape: int | tuple[int, ...], dtype: Any = float) -> np.ndarray:
    """Array of zeros; see `empty`."""
    array = empty(shape, dtype)
    array[...] = 0
    return array
