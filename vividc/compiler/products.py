"""The matrix products of a kernel, or of its nests: what a launch may run in a TPU-like mode."""

from __future__ import annotations

from dataclasses import replace

from vividc.arch import Accelerator, Fabric
from vividc.compiler.price import priced
from vividc.errors import KernelError, TimeLimit, warn
from vividc.frontend import KernelFunction, LLKernel
from vividc.gemm.modes import MODES
from vividc.host.watch import untold
from vividc.machine.product import AUTO, Products
from vividc.program import CUT_SHORT, Program
from vividc.ssa.formats.precision import Precision
from vividc.ssa.ir import Function
from vividc.ssa.parallel.nests import nests_of
from vividc.ssa.parallel.products import Found, recognise
from vividc.ssa.rewrite.contract import contract
from vividc.ssa.rewrite.normalize import canonical_loops


def forbidden(contract: bool, precision: Precision) -> str:
    """Why no product of a kernel may be run in a TPU-like mode; "" if one may."""
    if not contract:
        return "its sums are chains of FMAs, which --no-contract forbids"
    if precision:
        return "formats of its arithmetic or functions are chosen by --precision"
    return ""


def demanded_products(
    kernel: KernelFunction | LLKernel,
    machine: Fabric | Accelerator,
    mode: str,
    reason: str,
    strict_fp: bool,
) -> Products | None:
    """The matrix products that the kernel is made of, if it is; TPU-like modes demand them.

    Parameters
    ----------
    reason
        Why they may not be run in such a mode; "" if they may.

    Raises
    ------
    KernelError
        The mode is TPU-like, and the kernel or the machine has no such mode.
    """
    if not isinstance(machine, Accelerator):
        reason = "the fabric is one tile: give an accelerator, as vivid"
    elif not reason:
        found = products_of(kernel, strict_fp)
        if not found.reason:
            return Products(found.steps, found.strides, mode)
        reason = found.reason
    if mode in MODES:
        raise KernelError(
            f"{kernel.name} cannot run in mode {mode}: {reason}",
            hint="what is recognised as matrix products stands in docs/gemm.md; or choose the "
            "mode gpu",
        )
    return None


def products_of(kernel: KernelFunction | LLKernel, strict_fp: bool = False) -> Found:
    """The matrix products of a kernel, and why it is not made of such, if it is not."""
    return _found(untold(lambda: kernel.lower(strict_fp=strict_fp)))  # `prange` as any other loop


def _found(function: Function) -> Found:
    return recognise(canonical_loops(contract(function)))


def with_products(program: Program, function: Function, machine: Accelerator) -> Program:
    """The program, with those of its nests that are matrix products known as such."""
    if not program.nests:
        return program
    try:
        pairs = zip(program.nests, nests_of(function).nests, strict=True)
        nests = tuple(_with_product(nest, one.function, machine) for nest, one in pairs)
    except TimeLimit:
        text = f"the search for matrix products in nests of {program.name} {CUT_SHORT}"
        warn(text)
        return replace(program, warnings=(*program.warnings, text))
    return replace(program, nests=nests)


def _with_product(nest: Program, function: Function, machine: Accelerator) -> Program:
    found = _found(function)
    if found.reason:
        return nest
    known = Products(found.steps, found.strides, AUTO)
    return priced(replace(nest, products=known), machine, is_nest=True)
