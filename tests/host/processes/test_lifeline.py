"""A helper ends with the process that started it, even if that was killed."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

LIFELINE = Path(__file__).parents[3] / "vividc" / "host" / "processes" / "lifeline.py"


def test_a_busy_helper_ends_with_the_pipe(tmp_path: Path) -> None:
    (tmp_path / "busy.py").write_text(
        "import sys\nprint(sys.argv[1:], flush=True)\nwhile True: pass\n"
    )
    watched, ours = os.pipe()
    with subprocess.Popen(
        [sys.executable, str(LIFELINE), str(watched), "busy", "7"],
        env={**os.environ, "PYTHONPATH": str(tmp_path)},
        pass_fds=[watched],
        stdout=subprocess.PIPE,
    ) as helper:
        assert helper.stdout is not None
        assert helper.stdout.readline() == b"['7']\n"
        os.close(ours)  # as the end of this process would
        assert helper.wait(30) == 1
    os.close(watched)
