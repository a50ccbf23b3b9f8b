"""What the key of a kept program holds of vividc's own source."""

from __future__ import annotations

import shutil
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
