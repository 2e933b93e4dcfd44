"""GlobalIds of elements: 22 characters that stay the same from run to run."""

from __future__ import annotations

import string
import uuid
from collections.abc import Iterable
from itertools import chain
from typing import Final, Protocol

from indoor_bim.model import Storey

NAMESPACE: Final = uuid.UUID("8e9c7a52-6d0f-5b1e-9a3c-2f4d7b60c1a5")
_DIGITS: Final = string.digits + string.ascii_uppercase + string.ascii_lowercase + "_$"
_LENGTH: Final = 22


class Identified(Protocol):
    """Element of the model with an identifier and, where known, a GlobalId."""

    @property
    def id(self) -> str:
        """Identifier in the model."""
        ...

    @property
    def guid(self) -> str | None:
        """GlobalId, if the model gives one."""
        ...


def global_id(name: str) -> str:
    """Return the GlobalId of a name: its UUID (version 5) in the 64 digits of ISO 10303-21 identifiers.

    Parameters
    ----------
    name : str
        Anything; equal names give equal GlobalIds.

    Returns
    -------
    str
        22 characters.

    Examples
    --------
    >>> global_id("house.laz/Wall/W1")
    '0iPtQy_OvP49y8G$YLXguX'
    """
    number = uuid.uuid5(NAMESPACE, name).int
    return "".join(_DIGITS[number >> 6 * place & 63] for place in reversed(range(_LENGTH)))


def element_guid(source: str, element: Identified) -> str:
    """Return the GlobalId of an element: that of the model, or one made of the scan's name and the identifier.

    Parameters
    ----------
    source : str
        Name of the scan.
    element : Wall, Opening, Column, Room or Slab
        Element of the model.
    """
    return element.guid or global_id(f"{source}/{type(element).__name__}/{element.id}")


def storey_guids(source: str, storey: Storey) -> dict[str, str]:
    """Return the GlobalIds of all elements of a storey by their identifiers.

    Parameters
    ----------
    source : str
        Name of the scan.
    storey : Storey
        Part of the model.
    """
    openings = (opening for wall in storey.walls for opening in wall.openings)
    elements: Iterable[Identified] = chain(storey.walls, storey.columns, storey.rooms, storey.slabs, openings)
    return {element.id: element_guid(source, element) for element in elements}
