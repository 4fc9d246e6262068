"""Unknown keywords of functions, with the keyword that was probably meant."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import wraps
from inspect import signature
from typing import ParamSpec, TypeVar

from ase_roughcontact._util.validation import unknown

P = ParamSpec("P")
T = TypeVar("T")


def check_keywords(name: str, given: Iterable[str], known: Iterable[str]) -> None:
    """Raise `TypeError` for a keyword that a function does not have.

    Parameters
    ----------
    name : str
        Name of the function or class.
    given, known : iterable of str
        Keywords in a call, and the ones that exist.
    """
    names = list(known)
    for keyword in given:
        if keyword not in names:
            raise TypeError(unknown(keyword, names, f"argument of {name}()"))


def suggesting(function: Callable[P, T]) -> Callable[P, T]:
    """Return a function with errors that suggest a keyword for an unknown one.

    Parameters
    ----------
    function : callable
        Function that names all of its keywords.
    """
    known = [*signature(function).parameters]

    @wraps(function)
    def called(*arguments: P.args, **options: P.kwargs) -> T:
        check_keywords(function.__qualname__, options, known)
        return function(*arguments, **options)

    return called
