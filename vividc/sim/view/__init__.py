"""Views of a run.

In order: `recording` (a window of cycles), `vcd` (value changes), `perfetto` (traces), `heat_map`,
`roofline`.
"""

from vividc.sim.view.heat_map import heat_map, utilization
from vividc.sim.view.perfetto import Timeline, job_trace, run_trace
from vividc.sim.view.recording import Issued, Recording, record
from vividc.sim.view.roofline import Point, Roof, roof_above, roofline, tile_points, tile_roof
from vividc.sim.view.vcd import to_vcd

__all__ = [
    "Issued",
    "Point",
    "Recording",
    "Roof",
    "Timeline",
    "heat_map",
    "job_trace",
    "record",
    "roof_above",
    "roofline",
    "run_trace",
    "tile_points",
    "tile_roof",
    "to_vcd",
    "utilization",
]
