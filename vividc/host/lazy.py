"""Packages whose names are loaded when they are used (PEP 562), those of others among them."""

from __future__ import annotations

import builtins
import sys
from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec, PathFinder, SourceFileLoader
from types import ModuleType


def lazily(
    package: str, homes: Mapping[str, Sequence[str]], modules: Sequence[str] = ()
) -> tuple[Callable[[str], object], Callable[[], list[str]]]:
    """`__getattr__` and `__dir__` of a package.

    Parameters
    ----------
    homes
        Names that the package has, by the module that each is from.
    modules
        Modules and packages in it that are loaded when they are named.
    """
    home_of = {name: home for home, names in homes.items() for name in names}

    def load(name: str) -> object:
        if name in modules:
            return import_module(f"{package}.{name}")
        if name not in home_of:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        value = getattr(import_module(home_of[name]), name)
        setattr(sys.modules[package], name, value)
        return value

    def names() -> list[str]:
        return sorted({*vars(sys.modules[package]), *home_of, *modules})

    return load, names


def put_off(package: str, importer: str, classes: Sequence[str]) -> None:
    """Has `importer`, a module of somebody else's, load `package` when it uses it first: what it
    imports is a stand-in. Whoever else imports the package gets itself.

    Parameters
    ----------
    classes
        Those of the package that the importer names while it is loaded itself, as in annotations.
    """
    if importer not in sys.modules:
        sys.meta_path.insert(0, _Finder(package, importer, classes))


class _Finder(MetaPathFinder):
    def __init__(self, package: str, importer: str, classes: Sequence[str]) -> None:
        self._package, self._importer, self._classes = package, importer, classes

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        if fullname != self._importer or self._package in sys.modules:
            return None
        found = PathFinder.find_spec(fullname, path, target)
        if found is not None and type(found.loader) is SourceFileLoader:
            found.loader = _Loader(found.loader, self._package, self._classes)
        return found


class _Loader(SourceFileLoader):
    """Loads a module for which one package is a stand-in."""

    def __init__(self, like: SourceFileLoader, package: str, classes: Sequence[str]) -> None:
        super().__init__(like.name, like.path)
        self._package, self._classes = package, classes

    def exec_module(self, module: ModuleType) -> None:
        package = self._package
        instead = ModuleType(package)
        vars(instead).update({name: type(name, (), {}) for name in self._classes})

        def load(name: str, *how: object) -> object:
            return instead if name == package else builtins.__import__(name, *how)  # type: ignore[arg-type]

        vars(module)["__builtins__"] = {**vars(builtins), "__import__": load}
        super().exec_module(module)
        for name in self._classes:
            delattr(instead, name)
        vars(instead)["__getattr__"] = lambda name: getattr(import_module(package), name)
