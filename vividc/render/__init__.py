"""Scenes, cameras and float32 reference renderers: what the rendering kernels must equal."""

from vividc.render.blend_reference import Blended, blend_block, blend_image, over_background
from vividc.render.blocks import SPM_WORDS, BlendLaunch, assemble, cut_launches
from vividc.render.camera import Camera, load_cameras, load_reference_images, scaled_camera
from vividc.render.crop import TILE_PX, Crop
from vividc.render.errors import SceneError
from vividc.render.image import side_by_side, to_uint8, upscale_nearest, write_png
from vividc.render.metrics import psnr
from vividc.render.ply import Gaussians, read_gaussians
from vividc.render.splat import Projection, Splats, TileLists, bin_and_sort, project, tile_lists

__all__ = [
    "SPM_WORDS",
    "TILE_PX",
    "BlendLaunch",
    "Blended",
    "Camera",
    "Crop",
    "Gaussians",
    "Projection",
    "SceneError",
    "Splats",
    "TileLists",
    "assemble",
    "bin_and_sort",
    "blend_block",
    "blend_image",
    "cut_launches",
    "load_cameras",
    "load_reference_images",
    "over_background",
    "project",
    "psnr",
    "read_gaussians",
    "scaled_camera",
    "side_by_side",
    "tile_lists",
    "to_uint8",
    "upscale_nearest",
    "write_png",
]
