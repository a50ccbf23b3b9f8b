"""What the key of a kept program holds of vividc's own source; programs that are shipped."""

from __future__ import annotations

import shutil
import zlib
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest

import vividc
from vividc.errors import VividcWarning
from vividc.program import kept


def test_a_change_in_any_file_of_a_room_or_above_is_another_source(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    package = Path(kept.__file__).parent
    (tmp_path / "room" / "inner").mkdir(parents=True)
    (tmp_path / "other").mkdir()
    (tmp_path / "program").mkdir()
    shutil.copy(package / "kept.py", tmp_path / "program")
    monkeypatch.setattr(kept, "__file__", str(tmp_path / "program" / "kept.py"))
    seen = set()
    for name in ("room/a.py", "room/inner/a.py", "above.py", "room/inner/b.py"):
        (tmp_path / name).write_text("")
        seen.add(kept.source_digest.__wrapped__("room"))
    (tmp_path / "above.py").write_text("1")
    seen.add(kept.source_digest.__wrapped__("room"))
    last = kept.source_digest.__wrapped__("room")
    (tmp_path / "other" / "a.py").write_text("1")
    assert kept.source_digest.__wrapped__("room") == last
    assert len(seen) == 5


@dataclass(frozen=True)
class _Other:
    """Equal to all of its kind."""

    number: int = field(compare=False)


def test_other_values_are_other_texts() -> None:
    values = (1, "1", 1.0, -0.0, 0.0, True, None, (1,), (1, 2), ((1, 2),), frozenset({1}), {1: 2})
    texts = [kept.text_of(value) for value in (*values, _Other(1), _Other(2))]
    assert len(set(texts)) == len(texts)
    assert kept.text_of({"b": 1, "a": 2}) == kept.text_of({"a": 2, "b": 1})


@vividc.kernel("void(float32[::1], float32)")
def scaled(x, factor):
    for i in range(len(x)):
        x[i] *= factor


def test_a_shipped_program_is_the_same_but_for_where_its_source_was(tmp_path: Path) -> None:
    program = vividc.compile(scaled, "vivid-tile")
    root = Path(__file__).parent
    assert str(root).encode() in program.to_bytes()
    kept.write_shipped(tmp_path, "key", program, root)
    shipped = kept.read_shipped(tmp_path, "key")
    assert shipped is not None
    assert str(root).encode() not in shipped.to_bytes()
    np.testing.assert_array_equal(shipped.words, program.words)
    assert shipped.table == program.table
    places = {row.loc.file for row in shipped.debug if row.loc is not None}
    assert places == {Path(__file__).name}
    x = np.arange(9, dtype=np.float32)
    vividc.simulate(shipped, x, np.float32(3.0))
    np.testing.assert_array_equal(x, 3 * np.arange(9))


def test_shipped_programs_that_are_absent_or_damaged_are_none(tmp_path: Path) -> None:
    assert kept.read_shipped(tmp_path, "key") is None
    kept.write_shipped(tmp_path, "key", vividc.compile(scaled, "vivid-tile"), tmp_path)
    (file,) = tmp_path.iterdir()
    for content in (b"", b"words", file.read_bytes()[:-9], zlib.compress(b"words")):
        file.write_bytes(content)
        with pytest.warns(VividcWarning, match=r"key.*holds no program .* it is made anew"):
            assert kept.read_shipped(tmp_path, "key") is None
