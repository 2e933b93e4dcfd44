"""A table of rooms from a model. Usage: python examples/rooms_to_csv.py [model.json]."""

import csv
import sys

import indoor_bim
from indoor_bim.simulate import demo_house

building = indoor_bim.read_model(sys.argv[1]) if len(sys.argv) > 1 else demo_house()

table = csv.writer(sys.stdout)
table.writerow(["storey", "room", "area_m2", "height_m", "perimeter_m", "walls"])
for storey in building.storeys:
    for room in storey.rooms:
        perimeter = room.outline.polygon.exterior.length
        table.writerow([storey.name, room.name, f"{room.area:.2f}", f"{room.height:.3f}", f"{perimeter:.2f}", " ".join(room.walls)])
