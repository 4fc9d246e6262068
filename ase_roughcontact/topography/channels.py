"""Channels of a file of a microscope, and which of them is the height."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from ase_roughcontact._util.units import LENGTHS
from ase_roughcontact._util.validation import integer, shown, unknown

# Words in names of channels that are not the height, although the unit may be a length.
_NOT_HEIGHT = re.compile(
    "phase|amplitude|deflection|friction|lateral|current|error|potential|voltage"
    "|adhesion|dissipation|deformation|indentation|modulus|stiffness|intensity",
    re.IGNORECASE,
)


@dataclass(frozen=True)
class Channel:
    """One channel of a file.

    Attributes
    ----------
    name : str
        Name of the channel.
    shape : tuple of int
        Number of points along x and y; of a line profile along x only.
    unit : str, optional
        Unit of the values, if it is known.
    is_length : bool
        Whether the values may be lengths.
    """

    name: str
    shape: tuple[int, ...]
    unit: str | None = None
    is_length: bool = True

    @classmethod
    def with_unit(cls, name: str, shape: tuple[int, ...], unit: str | None) -> Channel:
        """Return a channel of lengths if the unit is a length or not known."""
        return cls(name, shape, unit, unit is None or unit in LENGTHS)

    @property
    def is_height(self) -> bool:
        """Whether unit and name belong to a height."""
        return self.is_length and not _NOT_HEIGHT.search(self.name)

    def __str__(self) -> str:
        """Return name, unit and shape."""
        shape = " x ".join(map(str, self.shape))
        return f"{self.name!r} ({self.unit or 'unit not known'}, {shape})"


def chosen(channels: Sequence[Channel], wanted: int | str | None = None) -> int:
    """Return the number, from 0, of the channel of the height.

    Parameters
    ----------
    channels : sequence of Channel
        Channels of the file, in order.
    wanted : int or str, optional
        Number or name of a channel; by default the only one that is a height.

    Raises
    ------
    ValueError
        If there is no channel, it is not found or no length, or none or several are
        heights.
    """
    if not channels:
        raise ValueError(
            "the file has no channel: it seems to be cut off, copy or export it again"
        )
    if wanted is None:
        found = [i for i, each in enumerate(channels) if each.is_height]
    elif isinstance(wanted, str):
        found = [i for i, each in enumerate(channels) if each.name == wanted]
        if not found:
            names = [each.name for each in channels]
            raise ValueError(unknown(wanted, names, "channel"))
    else:
        found = [integer("channel", wanted, 0)]
        if found[0] >= len(channels):
            raise ValueError(f"there is no channel {wanted}, only {_listed(channels)}")
    if not found:
        raise ValueError(f"no channel is a height: {_listed(channels)}")
    if len(found) > 1:
        reason = "could be the height" if wanted is None else f"are named {wanted!r}"
        raise ValueError(
            f"{len(found)} channels {reason}: give channel, the number or name: "
            f"{_listed(channels)}"
        )
    (number,) = found
    if not channels[number].is_length:
        raise ValueError(
            f"channel {shown(channels[number].name)} is no height, but in "
            f"{channels[number].unit or 'an unknown unit'}: {_listed(channels)}"
        )
    return number


def _listed(channels: Sequence[Channel]) -> str:
    return ", ".join(f"{i} {each}" for i, each in enumerate(channels))
