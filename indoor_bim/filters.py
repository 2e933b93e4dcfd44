"""Filters for point clouds: Open3D clouds or arrays in, the same kind out."""

from indoor_bim.cloud.filters import grid_radius_outlier_removal, statistical_outlier_removal
from indoor_bim.cloud.voxels import voxel_down_sample

__all__ = ["grid_radius_outlier_removal", "statistical_outlier_removal", "voxel_down_sample"]
