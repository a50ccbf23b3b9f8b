"""Reads a trained 3DGS scene from the `.ply` layout of the INRIA reference implementation."""

from __future__ import annotations

import io
import os
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import numpy as np
import numpy.typing as npt

from vividc.errors import demand_type, quoted
from vividc.host.inputs import SCENE_BYTES, read_bytes
from vividc.render.arrays import LARGEST_FLOAT32, Float32Array, frozen_float32
from vividc.render.errors import SceneError

_SCALAR_TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1",
    "short": "<i2", "int16": "<i2", "ushort": "<u2", "uint16": "<u2",
    "int": "<i4", "int32": "<i4", "uint": "<u4", "uint32": "<u4",
    "float": "<f4", "float32": "<f4", "double": "<f8", "float64": "<f8",
}  # fmt: skip
_FORMATS = ("ascii", "binary_little_endian")
_HEADER_END = b"end_header"
_HEADER_BYTES = 64 << 10
_ROWS_AT_ONCE = 1 << 12
_COUNT_DIGITS = 12
_LAYOUT_HINT = (
    "expected the INRIA layout: x y z, f_dc_0..2, f_rest_*, opacity, scale_0..2, rot_0..3"
)
_REST_COUNTS = {0: 1, 9: 4, 24: 9, 45: 16}
"""Number of `f_rest_*` properties -> spherical-harmonics coefficients a channel (degrees 0..3)."""


@dataclass(frozen=True, slots=True, eq=False)
class Gaussians:
    """The N Gaussians of a scene with their activations applied; all arrays float32, read-only.

    Attributes
    ----------
    means
        [N, 3] centres in world space.
    scales
        [N, 3] standard deviations along the local axes, world units (after exp).
    rotations
        [N, 4] unit quaternions w, x, y, z; local axes to world.
    opacity
        [N] in 0..1 (after the sigmoid).
    sh
        [N, K, 3] spherical-harmonics coefficients of r, g, b; K = 1, 4, 9 or 16 (degree 0..3).
    """

    means: Float32Array
    scales: Float32Array
    rotations: Float32Array
    opacity: Float32Array
    sh: Float32Array

    def __len__(self) -> int:
        return len(self.means)

    @property
    def sh_degree(self) -> int:
        """Degree 0..3 of the spherical harmonics."""
        return (1, 4, 9, 16).index(self.sh.shape[1])


@dataclass(frozen=True, slots=True)
class _Header:
    path: Path
    format: str
    vertices: int
    properties: tuple[tuple[str, str], ...]
    """Name and numpy type code of each vertex property, in file order."""
    body_start: int
    """Byte offset of the first vertex."""


def read_gaussians(path: Path | str) -> Gaussians:
    """Read a 3DGS `.ply` (ascii or binary little endian, SH degree 0..3, properties by name).

    Source of the layout: Kerbl et al., 3D Gaussian Splatting (2023), reference implementation;
    opacity is stored before the sigmoid, scale before exp, `f_rest` channel-major.

    Raises
    ------
    SceneError
        The file is missing, truncated, not a PLY, or lacks a property; names the file.
    """
    demand_type(path, (str, os.PathLike), "the path", "give a string or a pathlib.Path")
    path = Path(path)
    data = read_bytes(path, SCENE_BYTES, SceneError, "check the path")
    header = _parse_header(path, data)
    return _activate(header, _vertices(header, data))


def _parse_header(path: Path, data: bytes) -> _Header:
    if data[:3] != b"ply" or data[3:4] not in (b"\n", b"\r"):
        raise SceneError(
            "not a PLY file: it does not begin with the line `ply`",
            loc=str(path),
            hint="give the point_cloud.ply that 3DGS training writes",
        )
    marker = data.find(b"\n" + _HEADER_END, 0, _HEADER_BYTES)
    newline = data.find(b"\n", marker + 1)
    if marker < 0 or newline < 0:
        raise SceneError(
            f"the PLY header has no `end_header` line in its first {_HEADER_BYTES >> 10} KiB",
            loc=str(path),
            hint="the file is probably truncated: copy or download it again",
        )
    lines = data[:marker].decode("ascii", errors="replace").splitlines()[1:]
    words = [line.split() for line in lines]
    declarations = [w for w in words if w and w[0] not in ("comment", "obj_info")]
    return _Header(
        path=path,
        format=_format(path, declarations),
        vertices=_vertex_count(path, declarations),
        properties=_properties(path, declarations),
        body_start=newline + 1,
    )


def _format(path: Path, declarations: list[list[str]]) -> str:
    names = [w[1] for w in declarations if w[0] == "format" and len(w) > 1]
    if len(names) != 1 or names[0] not in _FORMATS:
        raise SceneError(
            f"unsupported PLY format {' '.join(names) or '(none given)'}",
            loc=str(path),
            hint=f"supported: {', '.join(_FORMATS)}",
        )
    return names[0]


def _vertex_count(path: Path, declarations: list[list[str]]) -> int:
    elements = [w for w in declarations if w[0] == "element"]
    if not elements or elements[0][1:2] != ["vertex"]:
        raise SceneError(
            "the first element of the PLY is not `vertex`", loc=str(path), hint=_LAYOUT_HINT
        )
    count = elements[0][2] if len(elements[0]) == len(("element", "vertex", "N")) else ""
    if not count.isascii() or not count.isdigit() or len(count) > _COUNT_DIGITS:
        raise SceneError(
            f"the vertex count {quoted(count)[1:-1] or '(none given)'} is not a number",
            loc=str(path),
            hint="the header line must read `element vertex N`",
        )
    return int(count)


def _properties(path: Path, declarations: list[list[str]]) -> tuple[tuple[str, str], ...]:
    """Return name and type of the properties of the first element; later elements are not read."""
    start = next(i for i, w in enumerate(declarations) if w[0] == "element") + 1
    properties: dict[str, str] = {}
    for words in declarations[start:]:
        if words[0] == "element":
            break
        if words[0] != "property":
            continue
        match words[1:]:
            case [kind, name] if kind in _SCALAR_TYPES and name not in properties:
                properties[name] = _SCALAR_TYPES[kind]
            case _:
                raise SceneError(
                    f"cannot use the vertex property `{' '.join(words)}`",
                    loc=str(path),
                    hint="vertex properties must be scalars with distinct names",
                )
    return tuple(properties.items())


def _vertices(header: _Header, data: bytes) -> npt.NDArray[np.void]:
    """Return the vertices as a structured array [N], one field a property."""
    dtype = np.dtype(list(header.properties))
    if header.format == "ascii":
        return _ascii_vertices(header, data, dtype)
    available = len(data) - header.body_start
    expected = header.vertices * dtype.itemsize
    if available < expected:
        raise SceneError(
            f"truncated: {header.vertices} vertices need {expected} bytes after the header, "
            f"the file has {available}",
            loc=str(header.path),
            hint="copy or download the file again",
        )
    return np.frombuffer(data, dtype=dtype, count=header.vertices, offset=header.body_start)


def _ascii_vertices(header: _Header, data: bytes, dtype: np.dtype[np.void]) -> npt.NDArray[np.void]:
    """By blocks of lines: all values as Python's would take twenty times the file."""
    width = len(header.properties)
    lines = io.BytesIO(data)
    lines.seek(header.body_start)
    room = (len(data) - header.body_start + 1) // (2 * width)  # a digit and a blank a value
    vertices = np.zeros(min(header.vertices, room), dtype=dtype)
    for first in range(0, header.vertices, _ROWS_AT_ONCE):
        wanted = min(_ROWS_AT_ONCE, header.vertices - first)
        values = [line.split(maxsplit=width) for line in islice(lines, wanted)]
        complete = sum(len(row) == width for row in values)
        if complete < wanted or first + wanted > len(vertices):
            raise SceneError(
                f"truncated: {first + complete} of {header.vertices} vertices have {width} values",
                loc=str(header.path),
                hint="one line a vertex, one value a property; copy or download the file again",
            )
        block = _numbers(header, values)
        for column, (name, _) in enumerate(header.properties):
            with np.errstate(over="ignore", invalid="ignore"):  # what does not fit is told of later
                vertices[name][first : first + wanted] = block[:, column]
    return vertices


def _numbers(header: _Header, values: list[list[bytes]]) -> npt.NDArray[np.float64]:
    try:
        return np.array([[float(value) for value in row] for row in values])
    except ValueError as error:
        raise SceneError(
            f"a vertex value is not a number: {error}",
            loc=str(header.path),
            hint="one line a vertex, one value a property",
        ) from error


def _columns(
    header: _Header, vertices: npt.NDArray[np.void], names: tuple[str, ...]
) -> npt.NDArray[np.float64]:
    """Return the named properties as [N, len(names)] float64; all values are finite."""
    present = {name for name, _ in header.properties}
    missing = [name for name in names if name not in present]
    if missing:
        raise SceneError(
            f"missing vertex property {', '.join(missing)}",
            loc=str(header.path),
            hint=_LAYOUT_HINT,
        )
    columns = np.empty((header.vertices, len(names)))
    for column, name in enumerate(names):
        with np.errstate(invalid="ignore"):  # a NaN that signals
            columns[:, column] = vertices[name]
        if not (np.abs(columns[:, column]) <= LARGEST_FLOAT32).all():
            raise SceneError(
                f"vertex property {name} holds a value that is not finite in float32",
                loc=str(header.path),
                hint="training diverged or the file is damaged",
            )
    return columns


def _activate(header: _Header, vertices: npt.NDArray[np.void]) -> Gaussians:
    rotations = _columns(header, vertices, ("rot_0", "rot_1", "rot_2", "rot_3"))
    norms = np.linalg.norm(rotations, axis=1, keepdims=True)
    if not norms.all():
        raise SceneError(
            f"the rotation of vertex {int(np.argmin(norms))} is the zero quaternion",
            loc=str(header.path),
            hint="training diverged or the file is damaged",
        )
    logits = _columns(header, vertices, ("opacity",))[:, 0]
    log_scales = _columns(header, vertices, ("scale_0", "scale_1", "scale_2"))
    return Gaussians(
        means=frozen_float32(_columns(header, vertices, ("x", "y", "z"))),
        # Nothing trained comes near the clamp; it keeps the float32 value finite.
        scales=frozen_float32(np.exp(np.clip(log_scales, -80.0, 80.0))),
        rotations=frozen_float32(rotations / norms),
        opacity=frozen_float32(np.exp(-np.logaddexp(0.0, -logits))),
        sh=_spherical_harmonics(header, vertices),
    )


def _spherical_harmonics(header: _Header, vertices: npt.NDArray[np.void]) -> Float32Array:
    """Return [N, K, 3]: `f_dc_c` is coefficient 0, `f_rest_{(K-1)c + k}` coefficient k+1 of c."""
    count = sum(name.startswith("f_rest_") for name, _ in header.properties)
    if count not in _REST_COUNTS:
        raise SceneError(
            f"{count} properties f_rest_* belong to no spherical-harmonics degree from 0 to 3",
            loc=str(header.path),
            hint=f"their number must be one of {', '.join(map(str, _REST_COUNTS))}",
        )
    coefficients = _REST_COUNTS[count]
    sh = np.empty((header.vertices, coefficients, 3), dtype=np.float32)
    for channel in range(3):
        first = (coefficients - 1) * channel
        names = [f"f_dc_{channel}", *(f"f_rest_{first + k}" for k in range(coefficients - 1))]
        for k, name in enumerate(names):  # one by one: most of a scene is here
            sh[:, k, channel] = _columns(header, vertices, (name,))[:, 0]
    sh.flags.writeable = False
    return sh
