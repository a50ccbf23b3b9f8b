"""`vividc.jit`: a function that is compiled for the types of its arguments when it is called, and
run on the simulated array.
"""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Iterator, Mapping
from typing import Any, Literal, overload

import numba
import numpy as np
from numba.core import types

from vividc import arch
from vividc.arch import Accelerator, Fabric
from vividc.compiler.driver import compile
from vividc.errors import ArgumentError, KernelError, SourceLoc, demand_type, quoted
from vividc.frontend import KernelFunction
from vividc.frontend.arguments import Form, form_of, function_of_rest, left_of
from vividc.frontend.kernel import kernel
from vividc.frontend.numba.vectorized.functions import as_function
from vividc.gemm.kernels.simulate import simulate
from vividc.launch import JobResult
from vividc.program import Program
from vividc.sim.run import Result

_NARROWER = {types.float64: "float32", types.int64: "int32", types.uint64: "uint32"}
_NARROWER |= {types.complex128: "complex64"}


class JitFunction:
    """A function of `vividc.jit`.

    Attributes
    ----------
    py_func, name
        The function as written, and its name.
    programs
        What it was compiled to, by the types of the arguments.
    program, report
        Of the last call: the program, and the result with cycles and statistics; None before.
    """

    def __init__(
        self,
        py_func: Callable[..., Any],
        fabric: str | Fabric | Accelerator,
        options: Mapping[str, Any],
        error_model: Literal["numpy", "python"] = "numpy",
    ) -> None:
        self._given = py_func
        py_func = as_function(py_func)
        functools.update_wrapper(self, py_func)
        self.py_func = py_func
        self.name = py_func.__name__
        self.programs: dict[tuple[Any, ...], Program] = {}
        self.program: Program | None = None
        self.report: Result | JobResult | None = None
        self._fabric = fabric
        self._options = dict(options)
        self._error_model = error_model
        self._kernels: dict[tuple[Any, ...], KernelFunction] = {}

    def __repr__(self) -> str:
        times = len(self.programs)
        return f"<vividc.jit {self.name}: compiled for {times} signature{'s' * (times != 1)}>"

    def __call__(self, *args: object, **kwargs: object) -> Any:
        """Run on the simulated array; arrays are updated in place.

        Raises
        ------
        ArgumentError, KernelError, ArchError, MappingFailed, TimeLimit, SimulationError
            As from `vividc.compile` and `vividc.simulate`.
        """
        given = self._bound(args, kwargs)
        machine = self._machine
        program = self._compiled(given)
        rest = [value for _, value in self._left(given)]
        if isinstance(machine, Accelerator):
            result: Result | JobResult = simulate(program, *rest, fabric=machine)
        else:
            result = simulate(program, *rest)
        self.program, self.report = program, result
        return result.value

    def reference(self, *args: object, **kwargs: object) -> Any:
        """Run on the host, through numba."""
        given = self._bound(args, kwargs)
        return self.kernel(*given)(*(value for _, value in self._left(given)))

    def kernel(self, *args: object, **kwargs: object) -> KernelFunction:
        """The kernel for the types of these arguments: of None and strings as its constants, and of
        the parts of tuples.

        Raises
        ------
        KernelError
            The function, or the types, are none of a kernel's.
        """
        given = self._bound(args, kwargs)
        key = self._types_of(given)
        if key not in self._kernels:
            forms = self._forms(given)
            function, signature = self._given, key
            if any(forms):
                function = function_of_rest(function, forms, self._error_model)
                signature = key[: -len(forms)]
            self._kernels[key] = kernel(signature, error_model=self._error_model)(function)
        return self._kernels[key]

    def _compiled(self, given: tuple[object, ...]) -> Program:
        key = self._types_of(given)
        if key not in self.programs:
            found = compile(self.kernel(*given), fabric=self._machine, **self._options)
            self.programs[key] = found
        return self.programs[key]

    @functools.cached_property
    def _machine(self) -> Fabric | Accelerator:
        return arch.load(self._fabric) if isinstance(self._fabric, str) else self._fabric

    def _bound(self, args: tuple[object, ...], kwargs: Mapping[str, object]) -> tuple[object, ...]:
        try:
            bound = inspect.signature(self.py_func).bind(*args, **kwargs)
        except TypeError as error:
            raise ArgumentError(f"{self.name}: {error}", loc=str(self._loc)) from error
        bound.apply_defaults()
        return bound.args

    @property
    def _loc(self) -> SourceLoc:
        return SourceLoc(self.py_func.__code__.co_filename, self.py_func.__code__.co_firstlineno)

    def _types_of(self, given: tuple[object, ...]) -> tuple[Any, ...]:
        """Types of the arrays and numbers of the arguments and, where there is more than these,
        what each argument is.
        """
        forms = self._forms(given)
        types_ = tuple(self._type_of(name, value) for name, value in self._left(given))
        return (*types_, *forms) if any(forms) else types_

    def _left(self, given: tuple[object, ...]) -> Iterator[tuple[str, object]]:
        """The arrays and numbers of the arguments, by name."""
        names = inspect.signature(self.py_func).parameters
        rest = (f"argument {place}" for place in range(len(names) + 1, len(given) + 1))
        for name, value, form in zip((*names, *rest), given, self._forms(given), strict=False):
            yield from left_of(name, value, form)

    def _forms(self, given: tuple[object, ...]) -> tuple[Form, ...]:
        """What the arguments are; strings are for parameters that have one, or None, by default."""
        defaults = [p.default for p in inspect.signature(self.py_func).parameters.values()]
        may_be_text = [isinstance(default, str | None) for default in defaults]
        may_be_text += [False] * len(given)
        return tuple(
            None if isinstance(value, str) and not may else form_of(value)
            for value, may in zip(given, may_be_text, strict=False)
        )

    def _type_of(self, name: str, value: object) -> Any:
        """Numba's type of an argument; of a Python float or complex number, which has no width,
        float32 or complex64.
        """
        if isinstance(value, float | complex) and not isinstance(value, np.generic):
            return types.float32 if isinstance(value, float) else types.complex64
        try:
            found = numba.typeof(value)
        except (ValueError, TypeError):
            found = None
        if not isinstance(found, types.Array | types.Number | types.Boolean):
            kind = type(value).__name__
            what = f"{name}, {quoted(value)}, cannot be an argument of {self.name}: it is a {kind}"
            raise ArgumentError(what, loc=str(self._loc), hint=_instead(name, value))
        if not isinstance(found, types.Array):
            return found
        narrower = _NARROWER.get(found.dtype)
        if narrower is not None or found.layout != "C":
            what = f"{name} is an array of {found.dtype}, and elements have up to 32 bits"
            if narrower is None:
                what = f"{name} is not contiguous in C order"
            given = name if narrower is None else f"{name}, np.{narrower}"
            hint = f"convert it first: {name} = np.ascontiguousarray({given})"
            raise ArgumentError(what, loc=str(self._loc), hint=hint)
        return found.copy(readonly=False)


def _instead(name: str, value: object) -> str:
    """What to pass for an argument of a type that no kernel takes."""
    if isinstance(value, list | tuple):
        return f"pass an array: {name} = np.array({name}, np.float32)"
    return "pass C-contiguous numpy arrays, numbers and booleans"


@overload
def jit(py_func: Callable[..., Any], /) -> JitFunction: ...


@overload
def jit(
    *,
    fabric: str | Fabric | Accelerator = "vivid-tile",
    error_model: Literal["numpy", "python"] = "numpy",
    **options: Any,
) -> Callable[[Callable[..., Any]], JitFunction]: ...


def jit(
    py_func: Callable[..., Any] | None = None,
    /,
    *,
    fabric: str | Fabric | Accelerator = "vivid-tile",
    error_model: Literal["numpy", "python"] = "numpy",
    **options: Any,
) -> JitFunction | Callable[[Callable[..., Any]], JitFunction]:
    """Let a function run on the simulated array: `@vividc.jit`, or `@vividc.jit(fabric="vivid")`.

    The first call with arguments of some types compiles it for these; a Python float is a float32.

    Parameters
    ----------
    py_func
        A Python function, or one that numba has compiled, with its options as of `vividc.kernel`,
        or that `numba.vectorize`, `guvectorize` or `stencil` has made.
    fabric
        A fabric or an accelerator, a preset's name, or a YAML file.
    error_model
        Numba's, as of `vividc.kernel`: what divisions by zero do.
    **options
        Of `vividc.compile`.

    Raises
    ------
    KernelError
        It is no function.
    ArgumentError
        The fabric is none, or an option is unknown.
    """
    demand_type(fabric, (str, Fabric, Accelerator), "the fabric", "give a name, as fabric='vivid'")
    unknown = options.keys() - inspect.signature(compile).parameters.keys()
    if unknown:
        hint = "options are those of vividc.compile"
        raise ArgumentError(f"jit has no option {min(unknown)}", hint=hint)

    def decorate(function: Callable[..., Any]) -> JitFunction:
        if not inspect.isfunction(as_function(function)):
            hint = "decorate a Python function, or one that numba.njit, vectorize or the like made"
            raise KernelError(f"a kernel cannot be made of {quoted(function)}", hint=hint)
        return JitFunction(function, fabric, options, error_model)

    return decorate if py_func is None else decorate(py_func)
