"""Published figures, each made by a command of this package."""

from typing import Final

PATIENCE: Final = 10.0
"""Times a limit that the clock allows: a busy machine makes the same tables, but for seconds."""
