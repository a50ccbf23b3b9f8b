"""What the key of a kept program holds of vividc's own source."""

from __future__ import annotations

import shutil
from dataclasses import dataclass, field
from pathlib import Path

import pytest

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
