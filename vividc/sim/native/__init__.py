"""The native engine: a program's configuration words as machine code of this computer."""

from vividc.sim.native.engine import NativeEngine

__all__ = ["NativeEngine"]
