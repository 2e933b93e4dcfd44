"""Zones: rooms that doors and passages join, such as a dwelling or a department."""

from __future__ import annotations

from collections.abc import Sequence

from indoor_bim.export.ifc_file import Entity, IfcFile
from indoor_bim.export.mesh import wall_frame
from indoor_bim.model import Opening, Room, Storey, Wall

PROBE = 0.10  # metres beyond a face of the wall: the room there is the one that a door leads to


def add_zones(ifc: IfcFile, storey: Storey, spaces: Sequence[Entity]) -> None:
    """Group the spaces of a storey that doors and passages join; a room that stands alone is in no zone.

    Parameters
    ----------
    ifc : IfcFile
        File to add to.
    storey : Storey
        Storey of the model.
    spaces : sequence of IfcSpace
        Entities of its rooms.
    """
    for number, members in enumerate(joined_rooms(storey), 1):
        name = f"{storey.id}-Z{number:02d}"
        zone = ifc.root("IfcZone", name, Name=name, ObjectType="Access", LongName="Rooms that doors and passages join")
        ifc.root("IfcRelAssignsToGroup", name, RelatedObjects=[spaces[k] for k in members], RelatingGroup=zone)


def joined_rooms(storey: Storey) -> list[list[int]]:
    """Return groups of two and more rooms of a storey, by their places in it, that doors and passages join.

    Parameters
    ----------
    storey : Storey
        Part of the model, metres.
    """
    import networkx as nx

    leading = ((wall, opening) for wall in storey.walls for opening in wall.openings if opening.kind != "window")
    beside = (_rooms_beside(wall, opening, storey.rooms) for wall, opening in leading)
    graph = nx.Graph(pair for pair in beside if None not in pair)
    return sorted(sorted(group) for group in nx.connected_components(graph) if len(group) > 1)


def _rooms_beside(wall: Wall, opening: Opening, rooms: Sequence[Room]) -> tuple[int | None, int | None]:
    """Places of the rooms to the right and to the left of an opening."""
    import numpy as np
    import shapely

    origin, along, left = wall_frame(wall)
    middle = origin + (opening.start + opening.width / 2) * along
    offsets = (np.asarray(wall.footprint) - origin) @ left

    def room_at(offset: float) -> int | None:
        point = shapely.Point(middle + offset * left)
        return next((k for k, room in enumerate(rooms) if room.outline.polygon.contains(point)), None)

    return room_at(float(offsets.min()) - PROBE), room_at(float(offsets.max()) + PROBE)
