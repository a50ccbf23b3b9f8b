"""Published figures, each made by a command of this package."""

import os
from typing import Final

from vividc.mapper import EffortLevel

PATIENCE: Final = 10.0
"""Times a limit that the clock allows: a busy machine makes the same tables, but for seconds."""

EFFORT: Final[EffortLevel] = "thorough"
"""Of the searches for mappings, in tables of cycles."""

os.environ.setdefault("VIVIDC_CACHE_PROGRAMS", "0")
"""What is measured is compiled, and not taken from an earlier run."""
