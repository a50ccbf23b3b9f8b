"""The keys of a fabric's YAML, as pydantic models; `docs/fabric-yaml.md` documents each of them.

`Spec` is the merged whole, in which nothing may be missing. A file may leave out what it inherits
through `extends`: `Layer` is the same with every key optional, made by `layer_of`.
"""

from __future__ import annotations

import re
from typing import Annotated, Any, Final, Literal, get_args

from pydantic import BaseModel, ConfigDict, Field, PlainValidator, create_model
from pydantic.fields import FieldInfo

from vividc.arch.topology import Topology
from vividc.machine.opcodes import LatencyClass

MAX_SIDE: Final = 32


WrittenBy = Literal["crossbar", "fu"]


Compute = Literal["int", "imul", "compare", "select", "fadd", "fmul", "fma", "convert", "generic"]
"""Names of the latency classes that an FU executes; loads and stores come with `memory`."""

TIMED_CLASSES: Final[tuple[LatencyClass, ...]] = tuple(
    lat for lat in LatencyClass if lat not in (LatencyClass.SOURCE, LatencyClass.SINK)
)
LATENCY_GROUPS: Final[dict[str, tuple[LatencyClass, ...]]] = {
    "all": TIMED_CLASSES,
    "float": (LatencyClass.FADD, LatencyClass.FMUL, LatencyClass.FMA, LatencyClass.DOT),
}

_AXES = 2
_RANGE = re.compile(r"(\d{1,4})\.\.(\d{1,4})")


def _is_index_item(value: object) -> bool:
    if isinstance(value, bool):
        return False
    if isinstance(value, int):
        return value >= 0
    return isinstance(value, str) and _RANGE.fullmatch(value) is not None


def _check_index_set(value: object) -> object:
    items = value if isinstance(value, list) else [value]
    if value == "all" or (items and all(_is_index_item(item) for item in items)):
        return value
    raise ValueError("should be `all`, an index, a range such as 0..3, or a list of these")


def _check_coordinates(value: object) -> object:
    if isinstance(value, list) and len(value) == _AXES and all(type(item) is int for item in value):
        return value
    raise ValueError("should be a PE as [row, col]")


def _check_executes(value: object) -> object:
    known = get_args(Compute)
    if value == "all" or (isinstance(value, list) and value and all(c in known for c in value)):
        return value
    raise ValueError(f"should be `all` or a list of some of {', '.join(known)}")


IndexSet = Annotated[int | str | list[int | str], PlainValidator(_check_index_set)]


def indices(spec: int | str | list[int | str], count: int) -> tuple[int, ...]:
    """The indices that an index set names, ascending, of a side of `count` PEs.

    Indices beyond the side are included: the caller reports them.
    """
    if spec == "all":
        return tuple(range(count))
    rows: set[int] = set()
    for item in spec if isinstance(spec, list) else [spec]:
        match = _RANGE.fullmatch(str(item))
        rows.update(range(int(match[1]), int(match[2]) + 1) if match else [int(item)])
    return tuple(sorted(rows))


class StrictModel(BaseModel):
    """No unknown keys, no conversions."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True, populate_by_name=True)


def layer_of(model: type[StrictModel], **keys: Any) -> type[StrictModel]:
    """`model` with every key optional, and so in its parts.

    Parameters
    ----------
    keys
        Type of keys that are others in a layer, or in a layer only.
    """
    types = {name: _in_layer(field) for name, field in model.model_fields.items()} | keys
    aliases = {name: field.alias for name, field in model.model_fields.items()}
    optional: dict[str, Any] = {
        name: (kind | None, Field(None, alias=aliases.get(name))) for name, kind in types.items()
    }
    return create_model(f"{model.__name__}Layer", __base__=StrictModel, **optional)


def _in_layer(field: FieldInfo) -> Any:
    kind = field.annotation
    if isinstance(kind, type) and issubclass(kind, StrictModel):
        demanding = any(one.is_required() for one in kind.model_fields.values())
        return layer_of(kind) if demanding else kind
    return Annotated[(kind, *field.metadata)] if field.metadata else kind


_Absent = Literal[
    "int", "imul", "compare", "select", "fadd", "fmul", "fma", "dot", "convert", "generic", "memory"
]
_Latency = Annotated[int, Field(ge=1, le=64)]
_Registers = Annotated[int, Field(ge=0, le=256)]
_Ports = Annotated[int, Field(ge=0, le=16)]
_Side = Annotated[int, Field(ge=1, le=MAX_SIDE)]
_Coordinates = Annotated[list[int], PlainValidator(_check_coordinates)]
_Executes = Annotated[Literal["all"] | list[Compute], PlainValidator(_check_executes)]
Name = Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]{0,63}$")]
"""What a layer may call itself; without a name it has its file's."""


class LinkSpec(StrictModel):
    """A directed link between two PEs, each as [row, col]."""

    src: _Coordinates = Field(alias="from")
    dst: _Coordinates = Field(alias="to")


class LinksSpec(StrictModel):
    """Links beside those of the topology."""

    extra: list[LinkSpec] = []
    removed: list[LinkSpec] = []


class RegisterFileSpec(StrictModel):
    """Size and ports of a register file."""

    registers: _Registers
    read_ports: _Ports
    write_ports: _Ports
    rotating: bool | None = None
    written_by: WrittenBy | None = None


class PESpec(StrictModel):
    """What every PE is made of unless an override says otherwise."""

    memory: bool
    executes: _Executes
    sliced: bool | None = None
    register_file: RegisterFileSpec
    constants: Annotated[int, Field(ge=0, le=1024)]


class RoutingSpec(StrictModel):
    """How words travel."""

    hops: Annotated[int, Field(ge=0, le=16)] | None = None
    output: Literal["pulse", "hold"] | None = None
    output_readers: Literal["own", "neighbours"] | None = None
    moves: bool | None = None


class At(StrictModel):
    """PEs by rows and columns: those in one of the rows and one of the columns."""

    rows: IndexSet = "all"
    cols: IndexSet = "all"


class Override(layer_of(PESpec)):  # type: ignore[misc]
    """Other settings for some PEs; later overrides win."""

    at: At


class LatenciesSpec(StrictModel):
    """Cycles of every latency class."""

    int_: _Latency = Field(alias="int")
    imul: _Latency
    compare: _Latency
    select: _Latency
    fadd: _Latency
    fmul: _Latency
    fma: _Latency
    dot: _Latency | None = None  # as `fma` if a file does not say
    convert: _Latency
    load: _Latency
    store: _Latency
    generic: _Latency


class ScratchpadSpec(StrictModel):
    """Capacity and banks."""

    size_bytes: Annotated[int, Field(ge=4, le=2**30)]
    banks: Annotated[int, Field(ge=1, le=1024)]


class ControllerSpec(StrictModel):
    """Parameters of the tile controller."""

    contexts: Annotated[int, Field(ge=1, le=65536)]
    control_latency: Annotated[int, Field(ge=0, le=64)]
    switch_cycles: Annotated[int, Field(ge=0, le=1024)]
    max_stages: Annotated[int, Field(ge=1, le=1024)]


class Spec(StrictModel):
    """A whole fabric after `extends` was resolved."""

    name: Name
    rows: _Side
    cols: _Side
    topology: Topology
    links: LinksSpec = LinksSpec()
    pe: PESpec
    overrides: list[Override] = []
    absent: list[_Absent] = []
    latencies: LatenciesSpec
    routing: RoutingSpec | None = None
    occupancy: layer_of(LatenciesSpec) | None = None  # type: ignore[valid-type]
    scratchpad: ScratchpadSpec
    controller: ControllerSpec
    clock_ghz: Annotated[float, Field(gt=0, le=100, allow_inf_nan=False)]


Layer: Final = layer_of(
    Spec,
    extends=str,
    latencies=layer_of(LatenciesSpec, **dict.fromkeys(LATENCY_GROUPS, _Latency)),
)
"""One YAML text. `all` and `float` set several latencies at once; a class by its name wins."""
