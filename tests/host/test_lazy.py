"""Packages that load what is used: their tables name all that they offer."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
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


_SERIES = """
import sys
import vividc
from vividc import mapper
from ortools.sat.python import cp_model
assert "pandas" not in sys.modules
model = cp_model.CpModel()
x = model.new_int_var(0, 5, "x")
model.add(2 * x >= 5)
solver = cp_model.CpSolver()
solver.solve(model)
assert 3 <= solver.value(x) <= 5
assert "pandas" not in sys.modules
import pandas
assert cp_model.pd.Series is pandas.Series
series = model.new_bool_var_series("y", pandas.Index([1, 2]))
assert type(series) is pandas.Series
"""


def test_the_solver_comes_without_what_its_series_need_until_somebody_uses_them() -> None:
    subprocess.run([sys.executable, "-c", _SERIES], check=True)


_OF_ONE_TILE = """
import sys
import vividc
from vividc.cli.kernels import load_kernel
vividc.compile(load_kernel("kernels/dot.py"), cache=False)
loaded = ("vividc.launch", "vividc.sim", "vividc.gemm.layer", "pandas", "PIL", "http")
assert not [name for name in loaded if name in sys.modules]
"""


def test_a_tile_s_compiler_comes_without_what_launches_need() -> None:
    subprocess.run([sys.executable, "-c", _OF_ONE_TILE], check=True)


_OF_A_PACKAGE = """
import sys
from vividc.host.lazy import put_off
put_off("late", "early", ("Thing",))
import early
assert "late" not in sys.modules
assert early.length("abc") == 3 and early.sorted_list([2, 1]) == [1, 2]
import late as own
assert early.late.Thing is own.Thing and own is not early.late
assert isinstance(early.made(), own.Thing)
"""


def test_a_package_is_put_off_for_one_importer_only(tmp_path: Path) -> None:
    (tmp_path / "late.py").write_text("class Thing:\n    pass\n")
    early = (
        "import late\nfrom json import dumps\nEither = late.Thing | None\n"
        "def made() -> late.Thing:\n    return late.Thing()\n"
        "def length(text):\n    return len(text)\n"
        "def sorted_list(items):\n    return sorted(items)\n"
    )
    (tmp_path / "early.py").write_text(early)
    env = {**os.environ, "PYTHONPATH": os.pathsep.join((str(tmp_path), os.getcwd()))}
    subprocess.run([sys.executable, "-c", _OF_A_PACKAGE], check=True, env=env)
