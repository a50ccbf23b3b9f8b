"""A frame in a process of its own: `python -m vividc.paper.child`, a request as JSON on standard
input and the row on standard output. By command line, so that a script that measures needs no
`if __name__ == "__main__"`.
"""

from __future__ import annotations

import json
import sys
from dataclasses import asdict
from pathlib import Path

from vividc.paper.frames import Key, measure_frame
from vividc.paper.scenes import Scenes


def main() -> None:
    """Measure what is asked for."""
    asked = json.load(sys.stdin)
    scenes = Scenes(tuple(map(Path, asked["scenes"])))
    row = measure_frame(Key(**asked["key"]), scenes, asked["folder"])
    print(json.dumps(asdict(row)))


if __name__ == "__main__":
    main()
