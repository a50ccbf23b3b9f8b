"""Tests leave the user's folders alone, and their outcome does not depend on chance or load."""

from __future__ import annotations

import gc
import os
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

# Numba's own code of a kernel is only compared with, a few times: it is right without LLVM's most
# thorough passes, which take as long as the rest of numba. It reads this when it is imported.
os.environ.setdefault("NUMBA_OPT", "1")

from tests import kept
from vividc.mapper.engines import greedy, negotiate

settings.register_profile(
    "tests", deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile("tests")

LONG = Path(__file__).with_name("long.txt")
"""The tests that take more than half a second, by their ids."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Marks those that are `long`."""
    known = frozenset(LONG.read_text(encoding="utf-8").splitlines())
    for item in items:
        if item.nodeid in known:
            item.add_marker(pytest.mark.long)


def pytest_collection_finish(session: pytest.Session) -> None:
    """What is here stays to the end of the run: garbage is looked for among what tests make, and
    less often, as they make a lot that is not (a twentieth of their time).
    """
    gc.collect()
    gc.freeze()
    gc.set_threshold(20_000, 20, 20)


@pytest.fixture(autouse=True, scope="session")
def own_cache(
    pytestconfig: pytest.Config, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[None]:
    """What is kept is kept for this run of the tests only, by all of its processes. Machine code of
    the mapper and of jobs' timing, which takes seconds, is taken from the last run: its key is all
    that it was made from. So is what numba makes of kernels.
    """
    folder = tmp_path_factory.getbasetemp()
    if os.environ.get("PYTEST_XDIST_WORKER"):
        folder = folder.parent  # a folder of the run, in which each process has its own
    entries = folder / "cache" / "entries"
    cache = getattr(pytestconfig, "cache", None)  # `-p no:cacheprovider`: a run like the first
    code = cache.mkdir("machine-code") if cache is not None else entries
    _copy_machine_code(code, entries)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("VIVIDC_CACHE_DIR", str(folder / "cache"))
        patch.setenv("VIVIDC_CACHE_PROGRAMS", "0")  # a test is of the compiler that it patches
        patch.setenv("XDG_STATE_HOME", str(folder / "state"))
        kept.take_from_cache(pytestconfig, patch, tmp_path_factory.getbasetemp())
        greedy.prepare()  # within no test's time limit
        negotiate.prepare()
        yield
    _copy_machine_code(entries, code)


def _copy_machine_code(source: Path, target: Path) -> None:
    """Entries that are not there yet, each as a whole: other processes copy at the same time."""
    target.mkdir(mode=0o700, parents=True, exist_ok=True)
    for entry in source.glob("loops-*"):
        if not (target / entry.name).exists():
            unfinished = target / f".{os.getpid()}-{entry.name}"
            shutil.copyfile(entry, unfinished)
            unfinished.chmod(0o600)
            unfinished.replace(target / entry.name)
