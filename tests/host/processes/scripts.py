"""Scripts that copy their process: pytest's own has threads, and is not copied."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path


def printed(script: str, folder: Path) -> str:
    """What a script prints in a process of its own, which has one thread as a compiler has."""
    command = [sys.executable, "-c", script]
    done = subprocess.run(
        command, capture_output=True, text=True, timeout=60, check=False, cwd=folder
    )
    assert not done.stderr
    return done.stdout
