"""Scenes, cameras and float32 reference renderers, and frames of which every stage is the array's.

In order: `errors`, `arrays`, `archive`, `ply`, `scenes` (files of all four methods); `camera`,
`orbit`, `views`, `crop`; `splat/` and `radiance/` (float32 references), `reference`; `image`,
`metrics`; `array/` (docs/rendering.md).
"""

from vividc.render.array.splats.blend_only import ArrayPicture, blend_on_array
from vividc.render.camera import Camera, load_cameras, load_reference_images, scaled_camera
from vividc.render.crop import TILE_PX, Crop
from vividc.render.errors import SceneError
from vividc.render.image import side_by_side, to_uint8, upscale_nearest, write_png
from vividc.render.metrics import psnr, ssim
from vividc.render.orbit import orbit_camera
from vividc.render.ply import Gaussians, read_gaussians
from vividc.render.reference import Picture, ReferenceOptions, render_reference
from vividc.render.scenes import METHODS, Scene, read_scene
from vividc.render.splat.blend_reference import (
    Blended,
    BlendOptions,
    blend_block,
    blend_image,
    over_background,
)
from vividc.render.splat.block_cull import seen_in
from vividc.render.splat.blocks import (
    SPM_WORDS,
    BlendLaunch,
    assemble,
    cut_launches,
    cut_small_launches,
)
from vividc.render.splat.splat import (
    Projection,
    Splats,
    TileLists,
    bin_and_sort,
    project,
    tile_lists,
)
from vividc.render.views import View, read_views

__all__ = [
    "METHODS",
    "SPM_WORDS",
    "TILE_PX",
    "ArrayPicture",
    "BlendLaunch",
    "BlendOptions",
    "Blended",
    "Camera",
    "Crop",
    "Gaussians",
    "Picture",
    "Projection",
    "ReferenceOptions",
    "Scene",
    "SceneError",
    "Splats",
    "TileLists",
    "View",
    "assemble",
    "bin_and_sort",
    "blend_block",
    "blend_image",
    "blend_on_array",
    "cut_launches",
    "cut_small_launches",
    "load_cameras",
    "load_reference_images",
    "orbit_camera",
    "over_background",
    "project",
    "psnr",
    "read_gaussians",
    "read_scene",
    "read_views",
    "render_reference",
    "scaled_camera",
    "seen_in",
    "side_by_side",
    "ssim",
    "tile_lists",
    "to_uint8",
    "upscale_nearest",
    "write_png",
]
