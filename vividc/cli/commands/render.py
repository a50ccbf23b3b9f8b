"""`vividc render`: a picture of a trained scene, and how good it is."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import click
import numpy as np
import numpy.typing as npt
from rich.console import Console
from rich.progress import Progress

import vividc
from vividc import arch
from vividc.cli import completion, options
from vividc.cli.files import check_apart, check_output
from vividc.cli.reports.frame import frame_body, print_frame
from vividc.cli.reports.report import print_json, print_table
from vividc.errors import VividcError
from vividc.render import (
    METHODS,
    ArrayPicture,
    Camera,
    Gaussians,
    Picture,
    ReferenceOptions,
    Scene,
    SceneError,
    View,
    blend_on_array,
    orbit_camera,
    psnr,
    read_scene,
    read_views,
    render_reference,
    ssim,
    write_png,
)
from vividc.render.array import (
    NETWORK_MODES,
    PRECISIONS,
    ArrayFrame,
    ArrayOptions,
    NetworkMode,
    RenderPrecision,
    render_array,
)
from vividc.render.arrays import Float32Array
from vividc.render.splat.blend_reference import BlendOptions

SCHEMA: Final = "vividc.render/1"
REFERENCE: Final = "reference"
ARRAY: Final = "array"
_DEFAULT_SIZE: Final = (800, 800)
MIN_SSIM_PX: Final = 11
_LARGEST_PX: Final = 8192
_ARRAY_HINT: Final = (
    "`vividc compile kernels/gs_blend.py --fabric vivid-tile -o gs_blend.vivid`, then "
    "`vividc render --engine array --blend gs_blend.vivid`"
)


def _size(
    _ctx: click.Context, _param: click.Parameter, value: str | None
) -> tuple[int, int] | None:
    """Return width and height of `WxH`."""
    if value is None:
        return None
    match = re.fullmatch(r"([0-9]{1,6})[xX]([0-9]{1,6})", value)
    if match is None:
        raise click.BadParameter(f"{value} is not a size like 800x800.")
    width, height = int(match[1]), int(match[2])
    if not (1 <= width <= _LARGEST_PX and 1 <= height <= _LARGEST_PX):
        raise click.BadParameter(f"{value}: sides are 1 to {_LARGEST_PX} pixels.")
    return width, height


@click.command("render")
@click.argument("scene", metavar="SCENE", type=options.FILE)
@click.option(
    "--method", type=click.Choice(METHODS), help="Kind of scene; by default, the file decides."
)
@click.option(
    "--views",
    "views_file",
    type=options.FILE,
    metavar="V",
    help="Cameras and pictures: transforms.json, or npz. Without: a camera around the scene.",
)
@click.option("--view", "view_index", type=int, metavar="N", help="Number of the view, from 0.")
@click.option(
    "--size",
    callback=_size,
    metavar="WxH",
    help="Size of the picture in pixels; by default the view's, or 800x800.",
)
@click.option("--azimuth", type=float, default=30.0, help="Degrees; without --views.")
@click.option("--elevation", type=float, default=20.0, help="Degrees; without --views.")
@click.option(
    "--up",
    type=click.Choice(["+x", "-x", "+y", "-y", "+z", "-z"]),
    default="+z",
    help="The scene's axis that points up; without --views.",
)
@click.option(
    "--lookahead",
    type=click.Choice(["on", "off"]),
    default="on",
    help="Lookahead Culling: colour networks (I) or exp (II) only where they count.",
)
@click.option(
    "--exponent-margin",
    type=float,
    default=BlendOptions().margin,
    metavar="M",
    help="3DGS: keep exponents down to ln(1 / (255 opacity)) - M.",
)
@click.option(
    "--weight-min",
    type=float,
    default=0.0,
    metavar="W",
    help="Ray-marched models: leave out the colour of samples of no greater weight.",
)
@click.option(
    "--engine",
    type=click.Choice([REFERENCE, ARRAY]),
    default=REFERENCE,
    help="Compute in float32 on the host, or on the array, compared with the host.",
)
@click.option(
    "--blend",
    "program",
    type=options.FILE,
    metavar="P.vivid",
    help="For --engine array: only blend there, by kernels/gs_blend.py compiled for its tile.",
)
@click.option(
    "--sample",
    type=float,
    default=1.0,
    metavar="SHARE",
    help="For --engine array: share of the blocks of pixels that is simulated; the rest is white.",
)
@click.option(
    "--precision",
    type=click.Choice(PRECISIONS),
    default="fp32",
    help="For --engine array: format of the networks' operands, or of 3DGS's exp.",
)
@click.option(
    "--mode",
    type=click.Choice(NETWORK_MODES),
    default="auto",
    help="For --engine array: of networks; gpu, or gpu and the TPU-like modes.",
)
@click.option(
    "--fabric",
    default="vivid",
    metavar="F",
    help="For --engine array: name of an accelerator, or a YAML file.",
    shell_complete=completion.accelerator,
)
@click.option("-o", "--output", type=options.FILE, metavar="P.png", help="Write the picture.")
@options.as_json
def command(
    scene: Path,
    method: str | None,
    views_file: Path | None,
    view_index: int | None,
    size: tuple[int, int] | None,
    azimuth: float,
    elevation: float,
    up: str,
    lookahead: str,
    exponent_margin: float,
    weight_min: float,
    engine: str,
    program: Path | None,
    sample: float,
    precision: RenderPrecision,
    mode: NetworkMode,
    fabric: str,
    output: Path | None,
    as_json: bool,
) -> None:
    """Render SCENE (3DGS .ply; npz of KiloNeRF, Instant-NGP, TensoRF) and compare with the truth.

    The reference engine computes in float32 on the host. With the array, the simulated tiles
    compute every sample and every pixel, stage by stage (with --blend, of 3DGS the blending alone).
    """
    if output is not None:
        _check_picture(output)
        check_apart({"-o": output}, [scene, *([] if views_file is None else [views_file])])
    if not np.isfinite(exponent_margin):
        raise click.BadParameter("not a finite number", param_hint="--exponent-margin")
    view = _view(views_file, view_index)
    found, model = read_scene(scene, method)
    _check_array_options(engine, program, sample, precision)
    _check_mode(engine, program, mode)
    blend = _blending(engine, program, model)
    camera = _camera(model, view, size, (azimuth, elevation, up))
    blending = BlendOptions(margin=exponent_margin)
    switches = ReferenceOptions(lookahead == "on", blending, weight_min=weight_min)
    wanted = None
    if engine == ARRAY and blend is None:
        wanted = ArrayOptions(
            *(fabric, "auto", lookahead == "on", exponent_margin, sample, precision, mode),
            weight_min=weight_min,
        )
    drawn = _draw(model, camera, switches, wanted, blend, fabric)
    if output is not None:
        write_png(output, drawn.image)
    truth = None if view is None else view.truth_at(camera.width, camera.height)
    body: dict[str, object] = {"scene": str(scene), "method": found, "engine": engine}
    body |= {"lookahead": lookahead, "weight_min": weight_min, "precision": precision, "mode": mode}
    body |= _body(drawn, truth)
    if as_json:
        print_json(SCHEMA, {**body, "output": None if output is None else str(output)})
    else:
        _print(body, None if view is None else view.name, output)
        if drawn.frame is not None:
            print_frame(drawn.frame)


def _check_picture(output: Path) -> None:
    if output.suffix.lower() != ".png":
        raise VividcError(f"`{output}` does not end in .png", loc="-o", hint="end it in .png")
    check_output(output, "-o")


def _view(views_file: Path | None, index: int | None) -> View | None:
    if views_file is None:
        if index is not None:
            raise SceneError("there are no views", loc="--view", hint="give --views as well")
        return None
    views = read_views(views_file)
    number = index or 0
    if not 0 <= number < len(views):
        raise SceneError(
            f"there is no view {number}: {views_file} has {len(views)}, from 0", loc="--view"
        )
    return views[number]


def _check_array_options(
    engine: str, program: Path | None, sample: float, precision: RenderPrecision
) -> None:
    """Refuse options that only the array's renderers have."""
    if sample != 1:
        if engine != ARRAY:
            raise SceneError("only the array is simulated", loc="--sample", hint="--engine array")
        if program is not None:
            raise SceneError(
                "with --blend all is simulated", loc="--sample", hint="leave out --blend"
            )
    if precision != "fp32":
        if engine != ARRAY:
            raise SceneError(
                "the reference is in fp32",
                loc="--precision",
                hint="--engine array, or leave it out",
            )
        if program is not None:
            raise SceneError(
                "with --blend its program decides",
                loc="--precision",
                hint="compile it with `vividc compile --precision exp=fp8`",
            )


def _check_mode(engine: str, program: Path | None, mode: NetworkMode) -> None:
    if mode != "auto" and (engine != ARRAY or program is not None):
        raise SceneError(
            "only networks on the array have one", loc="--mode", hint="--engine array, or leave out"
        )


def _camera(
    scene: Scene,
    view: View | None,
    size: tuple[int, int] | None,
    orbit: tuple[float, float, str],
) -> Camera:
    if view is None:
        return orbit_camera(scene, *orbit, *(size or _DEFAULT_SIZE))
    return view.camera if size is None else view.camera_at(*size)


def _blending(
    engine: str, program: Path | None, scene: Scene
) -> tuple[vividc.Program, Gaussians] | None:
    """Return what the array is given, or None if it is not asked for."""
    if engine == REFERENCE:
        if program is not None:
            raise SceneError("only the array blends with it", loc="--blend", hint=_ARRAY_HINT)
        return None
    if program is None:
        return None
    if not isinstance(scene, Gaussians):
        raise SceneError("only scenes of 3DGS are blended with it", loc="--blend")
    return vividc.load(program), scene


@dataclass(frozen=True, slots=True, eq=False)
class _Drawn:
    """A picture and the reference's; `frame`, `blended`: what the array's cost, as the report has
    it; `seen`: the pixels that were simulated, None: all.
    """

    picture: Picture
    image: Float32Array
    frame: dict[str, object] | None = None
    blended: dict[str, object] | None = None
    seen: npt.NDArray[np.bool_] | None = None


def _draw(
    scene: Scene,
    camera: Camera,
    switches: ReferenceOptions,
    wanted: ArrayOptions | None,
    blend: tuple[vividc.Program, Gaussians] | None,
    fabric: str,
) -> _Drawn:
    """Draw with the reference, and with the array if it is asked for."""
    frame = None if wanted is None else _on_array(scene, camera, wanted)
    with _bar(f"rendering {camera.width}x{camera.height}") as progress:
        picture = render_reference(scene, camera, switches, progress)
    if frame is not None:
        report = frame_body(frame, arch.load_accelerator(fabric), picture.image)
        return _Drawn(picture, frame.image, frame=report, seen=frame.simulated)
    if blend is not None:
        blended = blend_on_array(*blend, camera, fabric)
        return _Drawn(picture, blended.image, blended=_array_body(blended, picture.image))
    return _Drawn(picture, picture.image)


def _on_array(scene: Scene, camera: Camera, wanted: ArrayOptions) -> ArrayFrame:
    title = f"simulating {camera.width}x{camera.height}"
    with _bar(title) as progress:
        return render_array(scene, camera, wanted, progress, _tell)


def _tell(line: str) -> None:
    click.echo(line, err=True)


def _array_body(blended: ArrayPicture, reference: Float32Array) -> dict[str, object]:
    return {
        "psnr_reference_db": psnr(blended.image, reference),
        "host_stages": ["projection", "binning and sorting"],
        "blending_cycles": blended.cycles,
        "blending_ms": blended.milliseconds,
        "launches": blended.launches,
        "stats": blended.stats,
    }


def _body(drawn: _Drawn, truth: Float32Array | None) -> dict[str, object]:
    """Return the figures of a picture, of the pixels that were simulated."""
    image, seen = drawn.image, drawn.seen
    shown = np.clip(image, 0, 1)
    structure = truth is not None and seen is None and min(truth.shape[:2]) >= MIN_SSIM_PX
    part = slice(None) if seen is None else seen
    return {
        "width": image.shape[1],
        "height": image.shape[0],
        "psnr_truth_db": None if truth is None else psnr(shown[part], truth[part]),
        "ssim_truth": ssim(shown, truth) if structure and truth is not None else None,
        "counts": drawn.picture.counts,
        "seconds": round(drawn.picture.seconds, 3),
        "array": drawn.blended,
        "frame": drawn.frame,
    }


def _print(body: dict[str, object], view: str | None, output: Path | None) -> None:
    rows = [
        ("method", body["method"]),
        ("size", f"{body['width']}x{body['height']}"),
        ("precision", body["precision"]),
        ("view", "a camera around the scene" if view is None else view),
        ("PSNR against the truth", _decibel(body["psnr_truth_db"])),
        ("SSIM against the truth", _ratio(body["ssim_truth"])),
    ]
    counts = body["counts"]
    if isinstance(counts, dict):
        rows += [(name.replace("_", " "), f"{count:,}") for name, count in counts.items()]
    rows += [*_array_rows(body["array"]), ("seconds", body["seconds"]), ("written", output)]
    print_table(str(body["scene"]), ("", "value"), rows, numeric=("value",))


def _array_rows(array: object) -> list[tuple[str, object]]:
    if not isinstance(array, dict):
        return []
    return [
        ("PSNR of the array's against the reference", _decibel(array["psnr_reference_db"])),
        ("done by the host", ", ".join(array["host_stages"])),
        ("launches of the blend", f"{array['launches']:,}"),
        ("cycles of the blend", f"{array['blending_cycles']:,}"),
        ("milliseconds of the blend", f"{array['blending_ms']:.3f}"),
    ]


def _decibel(value: object) -> str | None:
    return f"{value:.2f} dB" if isinstance(value, float) else None


def _ratio(value: object) -> str | None:
    return f"{value:.4f}" if isinstance(value, float) else None


@contextmanager
def _bar(title: str) -> Iterator[Callable[[float], None] | None]:
    """Show a progress bar on stderr; None unless stderr is a terminal."""
    console = Console(stderr=True)
    if not console.is_terminal:
        yield None
        return
    with Progress(console=console, transient=True) as bar:
        task = bar.add_task(title, total=1.0)
        yield lambda share: bar.update(task, completed=share)
