"""What a fabric takes in area and a run in energy, from a cost table and counts of activity."""

from vividc.sim.costs.area import AreaReport, area
from vividc.sim.costs.calibration import Calibration, calibrate
from vividc.sim.costs.energy import EnergyReport, Work, energy, work_of
from vividc.sim.costs.report import Item

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
