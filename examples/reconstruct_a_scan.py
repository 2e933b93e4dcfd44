"""From a scan to a model. Usage: python examples/reconstruct_a_scan.py [SCAN] [OUT]."""

import sys
import tempfile
from pathlib import Path

import indoor_bim
from indoor_bim.simulate import demo_house, simulate, write_scan

folder = Path(sys.argv[2] if len(sys.argv) > 2 else tempfile.mkdtemp())
if len(sys.argv) > 1:
    scan = Path(sys.argv[1])
else:
    write_scan(simulate(demo_house(), profile="static", points=150_000), folder)
    scan = folder / "scan.laz"

result = indoor_bim.reconstruct(scan, out=folder, progress=lambda stage, share: print(f"{stage}: {share:.0%}"))

for warning in result.warnings:
    print("warning:", warning)
for storey in result.building.storeys:
    print(
        f"{storey.name}: {storey.height:.3f} m high, {len(storey.walls)} walls, {sum(room.area for room in storey.rooms):.1f} m2 of rooms"
    )
print("files:", *sorted(path.name for path in folder.iterdir()))
