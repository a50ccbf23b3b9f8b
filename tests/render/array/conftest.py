"""The accelerator on which the stages of a frame run."""

from __future__ import annotations

import pytest

import vividc
from vividc.render.array import Device
from vividc.render.array.device.programs import Programs


@pytest.fixture(scope="session")
def mapped() -> Programs:
    """Kernels are mapped with little effort: it costs cycles, of which no test here asks how many,
    and no result depends on it.
    """
    return Programs(vividc.arch.load_accelerator("vivid"), common={"effort": "fast"})


@pytest.fixture
def device(mapped: Programs) -> Device:
    """It has booked nothing yet."""
    return Device(mapped)
