"""A kernel that is one matrix product: which arrays it multiplies, and what follows."""

from __future__ import annotations

from dataclasses import dataclass

Size = str | int
"""A number that the launch gives, by its input key, or a constant."""


@dataclass(frozen=True, slots=True)
class Factor:
    """A matrix of the product, and where it lies.

    Attributes
    ----------
    array
        Parameter of two dimensions.
    transposed
        The product's first index is the array's second one.
    stride
        What the array's first index is multiplied with.
    """

    array: str
    transposed: bool
    stride: Size


@dataclass(frozen=True, slots=True)
class Product:
    """result = act(left right + bias), all of the kernel.

    Attributes
    ----------
    rows, cols, depth
        Iterations of the loops over rows and columns of the result, and of the inner one.
    bias
        Array of one dimension that is added, by column; "": none.
    starts
        The kernel's sum starts from the bias, or there is none: its order is that of the array.
    relu
        The greater of each result and 0 is stored.
    line
        Of the inner loop, in the source.
    mode
        "auto", "gpu", "tpu-unified", "tpu-partitioned": as asked for when it was compiled.
    cycles_a_term
        Of a tile in GPU-like mode, for each product of two elements, by estimate.
    """

    left: Factor
    right: Factor
    result: Factor
    rows: Size
    cols: Size
    depth: Size
    bias: str = ""
    starts: bool = True
    relu: bool = False
    line: str = ""
    mode: str = "auto"
    cycles_a_term: float = 0.0

    @property
    def arrays(self) -> tuple[str, ...]:
        """All arrays of the product."""
        names = (self.left.array, self.right.array, self.result.array)
        return (*names, self.bias) if self.bias else names

    @property
    def text(self) -> str:
        """The product as a formula."""
        left, right = (f.array + ("^T" if f.transposed else "") for f in (self.left, self.right))
        total = f"{left} {right}" + (f" + {self.bias}" if self.bias else "")
        result = self.result.array + ("^T" if self.result.transposed else "")
        return f"{result} = {f'max({total}, 0)' if self.relu else total}"
