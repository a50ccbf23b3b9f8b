"""What is shipped with an installation is what it looks for."""

from __future__ import annotations

import os
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import vividc
from vividc.cli.ship import COMPILED
from vividc.host.machine_code import units

_PACKAGE = Path(vividc.__file__).parent


def test_each_unit_without_vectors_is_shipped() -> None:
    found = [
        file.relative_to(_PACKAGE)
        for file in _PACKAGE.rglob("*.py")
        if " = Compiler(" in file.read_text(encoding="utf-8")
    ]
    for module in COMPILED:
        import_module(module)
    made = [unit for unit in units if unit.entries[0].__module__.startswith("vividc.")]
    scalar = [unit for unit in made if not unit.in_vectors]
    assert len(scalar) == len(COMPILED)
    assert len(found) == len(COMPILED) + 1, "one more computes vectors: vividc/render/radiance"


def test_nothing_is_compiled_with_what_is_shipped(tmp_path: Path) -> None:
    script = f"""
from pathlib import Path
from importlib import import_module
from vividc.cli import ship
from vividc.host.machine_code import door, shipped, units
folder = Path({str(tmp_path)!r}) / "objects"
ship.ship(folder)
shipped.FOLDER = folder
door.optimised = door.quickly = None
for unit in units:
    unit.prepare()
    assert not unit.is_quick
"""
    env = {**os.environ, "VIVIDC_CACHE_DIR": str(tmp_path / "cache")}
    subprocess.run([sys.executable, "-c", script], check=True, env=env, cwd=tmp_path)
    kept = list((tmp_path / "cache" / "entries").iterdir())
    assert len(kept) == len(COMPILED)
