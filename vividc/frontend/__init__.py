"""From a Python function to SSA: `@kernel` and what it gives."""

from vividc.frontend.kernel import KernelFunction, kernel

__all__ = ["KernelFunction", "kernel"]
