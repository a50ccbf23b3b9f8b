"""Stands in for `render.array.march.helper`: what it is sent as `work` says how it behaves."""

from __future__ import annotations

import os
import sys
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np

from vividc.render.array.device.frame import Ledger


def serve(pipe: Connection) -> None:
    behaviour = pipe.recv()
    if behaviour == "late":
        pipe.recv()  # for ever: nothing is sent before it is ready
    pipe.send("ready")
    while True:
        blocks = pipe.recv()
        Path(os.environ["ECHO_HELPER_TAKEN"]).touch()
        if behaviour == "dies":
            os._exit(1)
        if behaviour == "fails":
            pipe.send(None)
            continue
        ledger = Ledger()
        ledger.count(by_helper=len(blocks))
        pipe.send((np.full((len(blocks), 64, 4), blocks.corners[0, 0], np.float32), ledger))


if __name__ == "__main__":
    with Connection(int(sys.argv[1])) as connection:
        serve(connection)
