"""A process that renders batches of a frame for another one (`crew`): `python -m` with the file
descriptor of a pipe, over which come the `Work` and then batches.
"""

from __future__ import annotations

import sys
from multiprocessing.connection import Connection

from vividc.errors import VividcError
from vividc.render.array.march.batches import batch_renderer
from vividc.render.array.march.crew import Work
from vividc.render.array.march.fields import open_field


def serve(pipe: Connection) -> None:
    """Answer each batch with pixels and ledger, or with None where the frame has an error."""
    work: Work = pipe.recv()
    render = batch_renderer(*open_field(work.scene, work.options), work.camera, work.options)
    pipe.send("ready")
    while True:
        try:
            blocks = pipe.recv()
        except EOFError:
            return
        try:
            answer = render(blocks)
        except VividcError:
            answer = None
        pipe.send(answer)


if __name__ == "__main__":
    with Connection(int(sys.argv[1])) as connection:
        serve(connection)
