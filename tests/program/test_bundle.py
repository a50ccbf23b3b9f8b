"""`.vivid` files: they round-trip, are reproducible, and damage is always a `BundleError`."""

from __future__ import annotations

import io
import json
import random
import zipfile
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pytest

from tests.program.hand_kernels import dot, fabric, find, saxpy
from vividc import simulate
from vividc.errors import BundleError
from vividc.program import Program, load


@pytest.fixture(scope="module")
def saved(tmp_path_factory: pytest.TempPathFactory) -> tuple[Program, bytes]:
    program = dot(fabric(latencies="{fma: 4}"))
    path = tmp_path_factory.mktemp("bundle") / "dot.vivid"
    program.save(path)
    return program, path.read_bytes()


def rewritten(data: bytes, name: str, change: object) -> bytes:
    """The file with one member changed by `change` (bytes -> bytes), its checksum right."""
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        members = {member: archive.read(member) for member in archive.namelist()}
    members[name] = change(members[name])
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        for member, content in members.items():
            archive.writestr(member, content)
    return buffer.getvalue()


def edited(data: bytes, **changes: object) -> bytes:
    """The file with top-level keys of its manifest changed."""
    return rewritten(
        data, "program.json", lambda text: json.dumps(json.loads(text) | changes).encode()
    )


def refusal(path: Path, data: bytes) -> str:
    path.write_bytes(data)
    with pytest.raises(BundleError) as caught:
        load(path)
    assert str(path) in str(caught.value)
    return str(caught.value)


def test_round_trip_runs_the_same(saved: tuple[Program, bytes], tmp_path: Path) -> None:
    program, data = saved
    path = tmp_path / "again.vivid"
    path.write_bytes(data)
    again = load(path)
    assert again == program
    assert again.fabric == program.fabric
    x = np.arange(5, dtype=np.float32)
    assert simulate(again, x, x + 1, 5) == simulate(program, x, x + 1, 5)


def test_equality_sees_one_changed_word(saved: tuple[Program, bytes], tmp_path: Path) -> None:
    path = tmp_path / "other.vivid"
    path.write_bytes(saved[1])
    other = load(path)
    other.words[0, 0, 0] ^= 1
    assert other != saved[0]
    assert saxpy(fabric()) != find(fabric())


def test_same_program_gives_same_bytes(saved: tuple[Program, bytes], tmp_path: Path) -> None:
    again = dot(fabric(latencies="{fma: 4}"))
    again.save(tmp_path / "b.vivid")
    assert (tmp_path / "b.vivid").read_bytes() == saved[1]
    assert [path.name for path in tmp_path.iterdir()] == ["b.vivid"]


def test_truncated_anywhere(saved: tuple[Program, bytes], tmp_path: Path) -> None:
    data = saved[1]
    rng = random.Random(1)
    for size in (0, 1, 21, len(data) - 1, *(rng.randrange(len(data)) for _ in range(30))):
        refusal(tmp_path / "t.vivid", data[:size])


def test_changed_bytes_anywhere(saved: tuple[Program, bytes], tmp_path: Path) -> None:
    program, data = saved
    path = tmp_path / "f.vivid"
    rng = random.Random(2)
    refused = 0
    tail = [len(data) - 1 - k for k in range(150)]  # the zip directory, where most parsing happens
    for offset in (*tail, *(rng.randrange(len(data)) for _ in range(60))):
        broken = bytearray(data)
        broken[offset] ^= rng.randrange(1, 256)
        path.write_bytes(broken)
        try:
            assert load(path) == program
        except BundleError:
            refused += 1
    assert refused > 100


def test_other_schema(saved: tuple[Program, bytes], tmp_path: Path) -> None:
    message = refusal(tmp_path / "s.vivid", edited(saved[1], schema="vividc.program/99"))
    assert "vividc.program/99" in message
    assert "compile the kernel again" in message


def sized(program: Program, **known: list[int]) -> dict[str, object]:
    """Changes of a manifest that say sizes of parameters."""
    params = [asdict(param) | {"dtype": param.dtype.value} for param in program.params]
    return {"params": [p | {"known": known.get(p["name"], [])} for p in params]}


def test_only_programs_for_known_sizes_need_a_new_reader(
    saved: tuple[Program, bytes], tmp_path: Path
) -> None:
    program, data = saved
    for old in (data, rewritten(data, "program.json", _without_known)):
        assert b'"vividc.program/2"' in old
        (tmp_path / "old.vivid").write_bytes(old)
        assert load(tmp_path / "old.vivid") == program
    params = tuple(replace(p, known=(4,)) if p.name == "n" else p for p in program.params)
    known = replace(program, params=params)
    known.save(tmp_path / "new.vivid")
    assert b'"vividc.program/3"' in (tmp_path / "new.vivid").read_bytes()
    assert load(tmp_path / "new.vivid") == known != program


def _without_known(text: bytes) -> bytes:
    """A manifest as it was before sizes could be known."""
    manifest = json.loads(text)
    for param in manifest["params"]:
        del param["known"]
    return json.dumps(manifest).encode()


@pytest.mark.parametrize("known", [{"n": [4, 4]}, {"x": [4, 4]}, {"x": [-4]}, {"x": []}])
def test_known_sizes_that_cannot_be(
    saved: tuple[Program, bytes], tmp_path: Path, known: dict[str, list[int]]
) -> None:
    changed = edited(saved[1], **sized(saved[0], **known))
    if not any(known.values()):
        (tmp_path / "m.vivid").write_bytes(changed)
        assert load(tmp_path / "m.vivid") == saved[0]
        return
    assert "the sizes that it serves do not fit" in refusal(tmp_path / "m.vivid", changed)


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"contexts": 7}, "array words is not uint32 of shape"),
        ({"contexts": -1}, "array words"),
        ({"table": []}, "0 regions"),
        ({"opcodes": ["add"]}, "another opcode table"),
        ({"fabric": "rows: what"}, "its fabric cannot be read"),
        ({"launch": [{"pe": 99, "entry": 0, "key": "n"}]}, "entry 0 of PE 99"),
        ({"launch": [{"pe": 0, "entry": 0, "key": "nobody"}]}, "'nobody'"),
        ({"return_home": None}, "return"),
        ({"params": "x"}, "params"),
        ({"name": 3}, "(name should be a valid string)"),
        ({"warnings": [3] * 5000}, "(warnings.0 should be a valid string)"),
        ({"loops": [{"notes": [3] * 5000}]}, "(5,00"),
    ],
)
def test_inconsistent_manifest(
    saved: tuple[Program, bytes], tmp_path: Path, changes: dict[str, object], reason: str
) -> None:
    assert reason in refusal(tmp_path / "m.vivid", edited(saved[1], **changes))


def test_row_that_leaves_the_tables(saved: tuple[Program, bytes], tmp_path: Path) -> None:
    table = json.loads(zipfile.ZipFile(io.BytesIO(saved[1])).read("program.json"))["table"]
    for key, value in (("next", 9), ("context", 8), ("ii", 0), ("span", 0), ("branch", -2)):
        broken = [dict(row) for row in table]
        broken[0][key] = value
        refusal(tmp_path / "r.vivid", edited(saved[1], table=broken))


def test_words_that_mean_nothing(saved: tuple[Program, bytes], tmp_path: Path) -> None:
    message = refusal(
        tmp_path / "w.vivid", rewritten(saved[1], "words.npy", lambda b: b[:-20] + b"\xff" * 20)
    )
    assert "illegal code" in message or "does not have" in message


def test_foreign_and_hostile_files(saved: tuple[Program, bytes], tmp_path: Path) -> None:
    path = tmp_path / "x.vivid"
    refusal(path, b"not a zip file at all")
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        archive.writestr("program.json", "{}")
    assert "members" in refusal(path, buffer.getvalue())
    refusal(path, rewritten(saved[1], "program.json", lambda _: b"[" * 100_000))
    pickled = rewritten(saved[1], "words.npy", lambda b: b.replace(b"<u4", b"|O "))
    assert "array words" in refusal(path, pickled)
    bomb = io.BytesIO()
    with (
        zipfile.ZipFile(io.BytesIO(saved[1])) as good,
        zipfile.ZipFile(bomb, "w", zipfile.ZIP_DEFLATED) as archive,
    ):
        for name in good.namelist():
            archive.writestr(name, bytes(10_000_000))
    assert "not stored plainly" in refusal(path, bomb.getvalue())


def test_missing_file_and_missing_folder(saved: tuple[Program, bytes], tmp_path: Path) -> None:
    with pytest.raises(BundleError, match="cannot be read: No such file"):
        load(tmp_path / "none.vivid")
    with pytest.raises(BundleError, match="cannot be written: No such file"):
        saved[0].save(tmp_path / "none" / "a.vivid")
    with pytest.raises(BundleError, match="cannot be written"):
        saved[0].save(tmp_path)
    assert not list(tmp_path.iterdir())
