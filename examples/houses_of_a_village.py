"""Houses of an outdoor scan: footprints, heights, storeys. Usage: python examples/houses_of_a_village.py [SCAN]."""

import sys

from indoor_bim.houses import houses
from indoor_bim.simulate.village import sample_village, scan_village

scan = sys.argv[1] if len(sys.argv) > 1 else scan_village(sample_village(), density=60.0)
for house in houses(scan).village.houses:
    print(f"{house.id}: {house.area:.1f} m2, {house.storeys} storeys, {len(house.footprint)} corners")
