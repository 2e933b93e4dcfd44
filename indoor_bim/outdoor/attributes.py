"""Materials and other attributes of houses from a table."""

from __future__ import annotations

import csv
from dataclasses import dataclass, replace
from pathlib import Path

from indoor_bim.errors import ReadError
from indoor_bim.frame import Frame
from indoor_bim.outdoor.model import House

PLACE = ("x", "y")


@dataclass(frozen=True, slots=True)
class Row:
    """One line of the table: which house it is about, and what it says.

    Parameters
    ----------
    line : int
        Number of the line in the file.
    id : str, optional
        Identifier of the house.
    place : (float, float), optional
        Point in the house, scan coordinates.
    values : tuple of (str, str)
        Other columns.
    """

    line: int
    id: str | None
    place: tuple[float, float] | None
    values: tuple[tuple[str, str], ...]


def read_attributes(path: str | Path) -> tuple[Row, ...]:
    """Read a table of attributes.

    Parameters
    ----------
    path : path
        CSV with a header line; a column ``id``, or columns ``x`` and ``y`` in scan coordinates, and any others such as ``material``.

    Raises
    ------
    ReadError
        If the file is missing, no text, or has no such columns, or if a coordinate is no number.
    """
    file = Path(path)
    try:
        text = file.read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        raise ReadError(f"{file}: no such file; expected a table (CSV) of attributes") from None
    except (OSError, UnicodeDecodeError) as error:
        raise ReadError(f"{file}: cannot read the table ({error}); expected CSV in UTF-8") from None
    lines = text.splitlines()
    delimiter = ";" if lines and lines[0].count(";") > lines[0].count(",") else ","
    reader = csv.DictReader(lines, delimiter=delimiter)
    names = {name.strip().lower(): name for name in reader.fieldnames or ()}
    if "id" not in names and not all(name in names for name in PLACE):
        found = ", ".join(reader.fieldnames or ()) or "nothing"
        raise ReadError(f"{file}: found the columns {found}; expected id, or x and y, to know which house a line is about")
    rows = []
    for record in reader:
        values = {name: (record[column] or "").strip() for name, column in names.items()}
        if any(values.values()):
            rows.append(_row(values, reader.line_num, file))
    return tuple(rows)


def join_attributes(houses: tuple[House, ...], table: tuple[Row, ...], frame: Frame) -> tuple[tuple[House, ...], list[str]]:
    """Give each house what the table says of it.

    Parameters
    ----------
    houses : tuple of House
        Houses in model coordinates.
    table : tuple of Row
        Lines of the table; later ones win.
    frame : Frame
        Takes scan coordinates to model coordinates.

    Returns
    -------
    houses : tuple of House
        With material and attributes.
    warnings : list of str
        Lines that belong to no house.
    """
    import shapely

    joined = {house.id: house for house in houses}
    warnings = []
    for row in table:
        owner = row.id if row.id in joined else None
        if owner is None and row.place is not None:
            x, y, _ = frame.to_local([[*row.place, frame.origin[2]]])[0]
            inside = [house.id for house in houses if shapely.intersects_xy(house.polygon, x, y)]
            owner = inside[0] if inside else None
        if owner is None:
            warnings.append(f"Line {row.line} of the table of attributes belongs to no house.")
            continue
        house = joined[owner]
        known = {**dict(house.attributes), **dict(row.values)}
        material = known.pop("material", None) or house.material
        joined[owner] = replace(house, material=material, attributes=tuple(sorted(known.items())))
    return tuple(joined.values()), warnings


def _row(values: dict[str, str], line: int, file: Path) -> Row:
    place = None
    if values.get("x") and values.get("y"):
        try:
            place = (float(values["x"]), float(values["y"]))
        except ValueError:
            raise ReadError(f"{file}: line {line}: expected numbers in x and y, found {values['x']!r} and {values['y']!r}") from None
    rest = tuple((name, value) for name, value in values.items() if name not in ("id", *PLACE) and value)
    return Row(line, values.get("id") or None, place, rest)
