"""A virtual LiDAR walk through a known building."""

from indoor_bim.simulate.building import demo_house, office_floor, rounded_house, single_room, two_storeys
from indoor_bim.simulate.files import write_scan
from indoor_bim.simulate.scanner import SimulatedScan, profile_params, simulate

__all__ = [
    "SimulatedScan",
    "demo_house",
    "office_floor",
    "profile_params",
    "rounded_house",
    "simulate",
    "single_room",
    "two_storeys",
    "write_scan",
]
