"""What a method finds out about one storey: the common product that walls, rooms and the model are made from."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Self

from indoor_bim.plan.curve import Curve
from indoor_bim.plan.raster import Raster
from indoor_bim.plan.segments import Segments

if TYPE_CHECKING:
    import shapely


@dataclass(frozen=True, slots=True, eq=False)
class StoreyPlan:
    """Wall faces, levels and free space of one storey in model coordinates, metres.

    Parameters
    ----------
    faces : Segments
        Faces of walls; free space to the left where `sided`.
    floor : float or None
        Level of the floor; None where it was not seen.
    ceiling : float or None
        Level of the ceiling; None where it was not seen.
    seen : Raster, optional
        Image that is not zero where floor or ceiling was seen: free space.
    rooms : tuple of shapely.Polygon
        Free space of closed rooms, where the method finds them itself.
    room_levels : tuple of (float, float)
        Floor and ceiling of each of these rooms.
    pitched : bool
        True under a pitched roof: `ceiling` is its highest point.
    columns : tuple of shapely.Polygon
        Outlines of free-standing columns.
    curves : tuple of Curve
        Circles that the faces of curved walls lie on.
    warnings : tuple of str
        What was not seen or is doubtful.
    """

    faces: Segments
    floor: float | None
    ceiling: float | None
    seen: Raster | None = None
    rooms: tuple[shapely.Polygon, ...] = ()
    room_levels: tuple[tuple[float, float], ...] = ()
    pitched: bool = False
    columns: tuple[shapely.Polygon, ...] = ()
    curves: tuple[Curve, ...] = ()
    warnings: tuple[str, ...] = ()

    def lowered(self, height: float) -> Self:
        """Return the plan with its levels `height` metres lower."""
        floor, ceiling = (None if level is None else level - height for level in (self.floor, self.ceiling))
        return replace(
            self, floor=floor, ceiling=ceiling, room_levels=tuple((low - height, high - height) for low, high in self.room_levels)
        )
