"""Packages that load what is used: their tables name all that they offer."""

from __future__ import annotations

from types import ModuleType

import pytest

import vividc
from vividc import mapper


@pytest.mark.parametrize("package", [vividc, mapper], ids=lambda package: package.__name__)
def test_every_public_name_is_there(package: ModuleType) -> None:
    assert [name for name in package.__all__ if not hasattr(package, name)] == []
    assert set(package.__all__) <= set(dir(package))


@pytest.mark.parametrize("package", [vividc, mapper], ids=lambda package: package.__name__)
def test_any_other_name_is_none(package: ModuleType) -> None:
    with pytest.raises(AttributeError, match=f"module '{package.__name__}' has no attribute 'nam'"):
        _ = package.nam
