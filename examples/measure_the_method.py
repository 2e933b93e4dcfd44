"""How exact is the method? Scan a known room with a virtual LiDAR, reconstruct it, compare."""

import indoor_bim
from indoor_bim.simulate import simulate, single_room

for profile in ("clean", "static", "backpack"):
    scan = simulate(single_room(width=7.69, depth=6.35, height=3.0), profile=profile, points=100_000, seed=1)
    cloud = indoor_bim.Cloud(scan.points, gps_time=scan.gps_time, trajectory=scan.trajectory)
    result = indoor_bim.reconstruct(cloud)
    comparison = indoor_bim.compare(result.building, scan.truth)
    print(f"{profile:<9} length {comparison.length_mm:5.1f} mm, width {comparison.width_mm:5.1f} mm, height {comparison.height_mm:5.1f} mm")
