"""Generators that warn if nothing is ever taken from them."""

from __future__ import annotations

import sys
from collections.abc import Callable, Generator, Iterator
from functools import wraps
from typing import Any, ParamSpec, TypeVar

from ase_roughcontact._util.callers import warn

P = ParamSpec("P")
T = TypeVar("T")


def lazy(function: Callable[P, Iterator[T]]) -> Callable[P, Generator[T, None, None]]:
    """Return a function with a generator that warns if it is dropped unused.

    Parameters
    ----------
    function : callable
        Function that returns a generator, which works only while it is iterated over.
    """

    @wraps(function)
    def called(*arguments: P.args, **options: P.kwargs) -> Generator[T, None, None]:
        return Lazy(function(*arguments, **options), function.__qualname__)

    return called


class Lazy(Generator[T, None, None]):
    """Generator that warns if it is dropped before it has begun: nothing was done.

    Parameters
    ----------
    generator : generator
        Generator of the values.
    name : str
        Name of the function that the user has called, for the warning.
    """

    def __init__(self, generator: Any, name: str) -> None:
        self._generator, self._name, self._begun = generator, name, False

    def __next__(self) -> T:
        # warnings would point to the __next__ of the base class
        return self.send(None)

    def send(self, value: None) -> T:
        """Return the next value."""
        self._begun = True
        return self._generator.send(value)

    def throw(self, *error: Any) -> T:
        """Raise an exception where the generator waits."""
        self._begun = True
        return self._generator.throw(*error)

    def close(self) -> None:
        """End the generator."""
        self._begun = True
        self._generator.close()

    def __del__(self) -> None:
        if not self._begun and not sys.is_finalizing():
            warn(
                f"{self._name} has calculated nothing, as it works while its results "
                f"are iterated over: write list({self._name}(...)), or a for loop"
            )
