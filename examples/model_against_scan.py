"""Is the house built as drawn? A wall of the drawing that stands elsewhere in the scan is told. Usage: no arguments."""

from dataclasses import replace

import indoor_bim
from indoor_bim.quality.against import against_scan
from indoor_bim.quality.wall_bodies import bodies_of_building
from indoor_bim.simulate import simulate, single_room

scan = simulate(single_room(), profile="static", points=150_000, seed=1)
storey = scan.truth.storeys[0]
moved = replace(storey.walls[0], footprint=tuple((x, y + 0.04) for x, y in storey.walls[0].footprint))
drawing = replace(scan.truth, storeys=(replace(storey, walls=(moved, *storey.walls[1:])),))

deviations = against_scan(bodies_of_building(drawing), indoor_bim.Cloud(scan.points))
for wall in deviations.walls:
    off = "no points" if wall.bias is None else f"{1000 * wall.bias:+.1f} mm"
    print(f"{wall.name}: {wall.status}, the scan lies {off} in front of it")
