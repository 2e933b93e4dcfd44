"""Levelling by principal components and its steps: floor, ceiling and the vertical of a scan at any attitude."""

from indoor_bim.cloud.floor_and_ceiling import FloorAndCeiling, find_floor_and_ceiling, main_body
from indoor_bim.cloud.horizontal_planes import alone_in_cell, horizontal_layers, horizontal_plane, sharpest_normal, vertical_axis
from indoor_bim.cloud.pca_levelling import level_by_pca
from indoor_bim.cloud.plane import Plane, fit_plane, mean_normal, principal_axes, refit_plane, rotation_to_z

__all__ = [
    "FloorAndCeiling",
    "Plane",
    "alone_in_cell",
    "find_floor_and_ceiling",
    "fit_plane",
    "horizontal_layers",
    "horizontal_plane",
    "level_by_pca",
    "main_body",
    "mean_normal",
    "principal_axes",
    "refit_plane",
    "rotation_to_z",
    "sharpest_normal",
    "vertical_axis",
]
