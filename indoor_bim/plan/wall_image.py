"""The picture of a wall in colours."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from indoor_bim.plan.wall_picture import WallPicture

Bytes = NDArray[np.uint8]

NOTHING = (235, 235, 235)
FACE = (90, 90, 90)
ENTERED = (240, 170, 60)
THROUGH = (70, 140, 230)
FRONT = (150, 200, 150)
FRAME = (220, 30, 30)
SIGNATURE = b"\x89PNG\r\n\x1a\n"


def wall_image(picture: WallPicture, openings: Iterable[tuple[float, float, float, float]] = (), *, zoom: int = 4) -> Bytes:
    """Colours of a wall's picture: face grey, rays that went in orange, rays that went through blue, things in front green.

    Parameters
    ----------
    picture : WallPicture
        Picture of one wall.
    openings : iterable of (start, end, bottom, top)
        Rectangles to outline in red, metres.
    zoom : int
        Pixels along each side of a cell.

    Returns
    -------
    (height, width, 3) uint8
        RGB, row 0 at the top of the wall.
    """
    face, entered, through = (counts.sum(axis=0) for counts in (picture.face, picture.entered, picture.through))
    image = np.full((*face.shape, 3), NOTHING, dtype=np.float64)
    total = face + entered
    image[(picture.front > 0) & (total == 0)] = FRONT
    seen = total > 0
    share = np.where(seen, total, 1)[:, :, None]
    colours = [(face, FACE), (entered - through, ENTERED), (through, THROUGH)]
    mixed = sum(counts[:, :, None] * np.array(colour) for counts, colour in colours)
    image[seen] = (mixed / share)[seen]
    pixels = np.repeat(np.repeat(np.round(image).astype(np.uint8), zoom, axis=0), zoom, axis=1)
    height, width = pixels.shape[:2]
    scale = zoom / picture.cell
    for start, end, bottom, top in openings:
        left, right = np.clip(np.round(np.array([start, end]) * scale).astype(int), 0, width - 1)
        low, high = np.clip(np.round(np.array([bottom, top]) * scale).astype(int), 0, height - 1)
        pixels[low : high + 1, [left, right]] = FRAME
        pixels[[low, high], left : right + 1] = FRAME
    flipped: Bytes = pixels[::-1]
    return flipped


def png_bytes(image: Bytes) -> bytes:
    r"""Encode an RGB image as PNG (ISO/IEC 15948).

    Parameters
    ----------
    image : (height, width, 3) uint8
        Row 0 at the top.

    Raises
    ------
    ValueError
        If the image has another shape or type.

    Examples
    --------
    >>> png_bytes(np.zeros((1, 1, 3), dtype=np.uint8))[:4]
    b'\x89PNG'
    """
    if image.ndim != 3 or image.shape[2] != 3 or image.dtype != np.uint8:
        raise ValueError(f"expected an image of shape (height, width, 3) and type uint8, got {image.shape} and {image.dtype}")
    height, width = image.shape[:2]
    rows = np.concatenate([np.zeros((height, 1), dtype=np.uint8), image.reshape(height, width * 3)], axis=1)
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return SIGNATURE + _chunk(b"IHDR", header) + _chunk(b"IDAT", zlib.compress(rows.tobytes(), 6)) + _chunk(b"IEND", b"")


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
