"""The tests of the simulator hold for both engines: `simulate` runs each in turn."""

from __future__ import annotations

import pytest

from vividc.sim.native import NativeEngine
from vividc.sim.reference.engine import ReferenceEngine
from vividc.sim.tile import AUTO, ENGINES


@pytest.fixture(autouse=True, params=[ReferenceEngine, NativeEngine], ids=["reference", "native"])
def engine(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(ENGINES, AUTO, request.param)
