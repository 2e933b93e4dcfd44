"""Walls of anybody's IFC file, of IFC2X3, IFC4 or IFC4X3, in metres."""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Collection, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from indoor_bim.errors import ReadError
from indoor_bim.quality.wall_bodies import Body, WallModel

_OF_ONE_STOREY = ("IfcWall", "IfcWindow", "IfcDoor", "IfcFurnishingElement", "IfcRailing")
_NO_BODIES = ("IfcOpeningElement", "IfcVirtualElement", "IfcAnnotation", "IfcGrid")


def bodies_of_ifc(path: str | os.PathLike[str]) -> WallModel:
    """Read walls and other elements of an IFC file.

    Parameters
    ----------
    path : path
        IFC file; lengths in any unit.

    Returns
    -------
    WallModel
        Bodies in the file's coordinates, metres, openings cut out. A file that tells its matrix from scan to model keeps it.

    Raises
    ------
    ReadError
        If the file is missing, damaged, no IFC file, or without walls.
    """
    return walls_of_ifc(path).detailed(None)


def walls_of_ifc(path: str | os.PathLike[str]) -> WallModel:
    """Read the walls of an IFC file without their openings, in a fraction of the time; the rest follows storey by storey.

    Parameters
    ----------
    path : path
        IFC file; lengths in any unit.

    Returns
    -------
    WallModel
        Walls in the file's coordinates, metres; `WallModel.detailed` cuts their openings out and adds the other elements.

    Raises
    ------
    ReadError
        If the file is missing, damaged, no IFC file, or without walls.
    """
    import ifcopenshell
    import ifcopenshell.util.unit

    name = Path(path)
    try:
        file: Any = ifcopenshell.open(str(name))
    except (OSError, ifcopenshell.Error) as error:
        raise ReadError(f"{name}: is no IFC file that can be read ({error}); expected a STEP file of IFC2X3, IFC4 or IFC4X3.") from error
    entities = file.by_type("IfcWall")
    if not entities:
        raise ReadError(f"{name}: holds no walls (IfcWall); expected the model of a building.")
    scale = ifcopenshell.util.unit.calculate_unit_scale(file)
    storeys = sorted((float(s.Elevation or 0.0) * scale, s.Name or "") for s in file.by_type("IfcBuildingStorey"))
    return WallModel(
        walls=_walls(_bodies(file, entities, cut=False)),
        others=(),
        storeys=tuple((label, level) for level, label in storeys),
        scan_to_model=_transform(file),
        source=_own(file, "Source") or "",
        detail=partial(_detail, file),
    )


def _detail(file: Any, names: Collection[str] | None) -> tuple[tuple[Body, ...], tuple[Body, ...]]:
    """Walls with openings, and other elements, of some storeys; what may reach through several storeys comes from all of them."""

    def wanted(element: Any, kinds: tuple[str, ...]) -> bool:
        return names is None or not _is_any(element, kinds) or _storey(element) in names

    elements = [element for element in file.by_type("IfcElement") if element.Representation and not _is_any(element, _NO_BODIES)]
    bodies = _bodies(file, [element for element in elements if wanted(element, _OF_ONE_STOREY)], cut=True)
    others = [body for is_wall, body in bodies if not is_wall]
    return _walls(bodies), tuple(sorted(others, key=lambda body: body.guid))


def _walls(bodies: list[tuple[bool, Body]]) -> tuple[Body, ...]:
    return tuple(sorted((body for is_wall, body in bodies if is_wall), key=lambda body: (body.storey, body.id, body.guid)))


def _bodies(file: Any, elements: Sequence[Any], *, cut: bool) -> list[tuple[bool, Body]]:
    """Bodies of elements, and whether each is a wall."""
    import ifcopenshell.geom

    settings: Any = ifcopenshell.geom.settings()  # type: ignore[no-untyped-call]
    settings.set("use-world-coords", True)
    settings.set("weld-vertices", True)
    settings.set("disable-opening-subtractions", not cut)
    iterator: Any = ifcopenshell.geom.iterator(settings, file, multiprocessing.cpu_count(), include=list(elements))
    found: list[tuple[bool, Body]] = []
    if elements and iterator.initialize():
        while True:
            shape = iterator.get()
            entity = file.by_id(shape.id)
            vertices = np.array(shape.geometry.verts, dtype=np.float64).reshape(-1, 3)
            triangles = np.array(shape.geometry.faces, dtype=np.int64).reshape(-1, 3)
            body = Body(entity.Tag or entity.GlobalId, entity.Name or "", entity.GlobalId, _storey(entity), vertices, triangles)
            found.append((entity.is_a("IfcWall"), body))
            if not iterator.next():
                break
    return found


def _is_any(entity: Any, kinds: tuple[str, ...]) -> bool:
    return any(entity.is_a(kind) for kind in kinds)


def _storey(entity: Any) -> str:
    """Name of the storey that holds an element."""
    import ifcopenshell.util.element

    container = ifcopenshell.util.element.get_container(entity)
    return str(container.Name or "") if container is not None else ""


def _transform(file: Any) -> np.ndarray | None:
    """Matrix from scan to model, in files of this program."""
    values = _own(file, "TransformCloudToModel")
    return np.array(values, dtype=np.float64).reshape(4, 4) if values is not None and len(values) == 16 else None


def _own(file: Any, name: str) -> Any:
    import ifcopenshell.util.element

    for building in file.by_type("IfcBuilding"):
        value = ifcopenshell.util.element.get_pset(building, "IndoorBim_Reconstruction", name)
        if value is not None:
            return value
    return None
