"""Which doors and windows are in the walls? Usage: python examples/doors_and_windows.py [SCAN]."""

import sys

import indoor_bim
from indoor_bim.simulate import simulate, single_room

if len(sys.argv) > 1:
    scan = indoor_bim.read(sys.argv[1])
else:
    walk = simulate(single_room(), profile="backpack", points=100_000, seed=1)
    scan = indoor_bim.Cloud(walk.points, gps_time=walk.gps_time, trajectory=walk.trajectory)

for storey in indoor_bim.reconstruct(scan).building.storeys:
    for wall in storey.walls:
        for opening in wall.openings:
            print(
                f"{storey.name}, {wall.name}: {opening.kind} {opening.width:.2f} m x {opening.height:.2f} m, "
                f"{opening.start:.2f} m from the end of the wall, {opening.sill:.2f} m up, {opening.confidence:.0%} certain"
            )
