"""What a fabric takes in area and a run in energy, from a cost table and counts of activity.

In order: `report` (items), `components`, `area`, `energy`, `calibration`.
"""

from vividc.sim.cost.area import AreaReport, area
from vividc.sim.cost.calibration import Calibration, calibrate
from vividc.sim.cost.energy import EnergyReport, Work, energy, work_of
from vividc.sim.cost.report import Item

__all__ = [
    "AreaReport",
    "Calibration",
    "EnergyReport",
    "Item",
    "Work",
    "area",
    "calibrate",
    "energy",
    "work_of",
]
