"""Grid radius outlier removal is Open3D's radius outlier removal: same points, same order."""

import numpy as np
import open3d as o3d

from indoor_bim import filters

rng = np.random.default_rng(0)
wall = np.column_stack([rng.uniform(0, 5, 20_000), rng.normal(scale=0.005, size=20_000), rng.uniform(0, 2.5, 20_000)])
dust = rng.uniform([0, -2, 0], [5, 2, 2.5], (500, 3))
cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(np.concatenate([wall, dust])))

kept, index = filters.grid_radius_outlier_removal(cloud, nb_points=8, radius=0.1)
_, reference = cloud.remove_radius_outlier(nb_points=8, radius=0.1)

print(f"{len(cloud.points)} points, {len(kept.points)} kept")
if list(index) != list(reference):
    raise SystemExit("the two differ")
