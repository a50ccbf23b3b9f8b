"""What steps wait for, and the check that no graph's result depends on timing.

In order: `waits`, `races` (machine code), `check`.
"""

from vividc.launch.hazards.check import check_order
from vividc.launch.hazards.waits import predecessors

__all__ = ["check_order", "predecessors"]
