"""Packages that load what is used: their tables name all that they offer."""

from __future__ import annotations

import subprocess
import sys
from types import ModuleType

import pytest

import vividc
from vividc import gemm, mapper


@pytest.mark.parametrize("package", [vividc, mapper, gemm], ids=lambda package: package.__name__)
def test_every_public_name_is_there(package: ModuleType) -> None:
    assert [name for name in package.__all__ if not hasattr(package, name)] == []
    assert set(package.__all__) <= set(dir(package))


@pytest.mark.parametrize("package", [vividc, mapper, gemm], ids=lambda package: package.__name__)
def test_any_other_name_is_none(package: ModuleType) -> None:
    with pytest.raises(AttributeError, match=f"module '{package.__name__}' has no attribute 'nam'"):
        _ = package.nam


_OF_ONE_TILE = """
import sys
import vividc
from vividc.cli.kernels import load_kernel
vividc.compile(load_kernel("kernels/dot.py"), cache=False)
loaded = ("vividc.launch", "vividc.sim", "vividc.gemm.layer", "PIL")
assert not [name for name in loaded if name in sys.modules]
"""


def test_a_tile_s_compiler_comes_without_what_launches_need() -> None:
    subprocess.run([sys.executable, "-c", _OF_ONE_TILE], check=True)
