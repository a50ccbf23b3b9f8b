"""The marching pipeline with a field that the host computes: every other stage is the array's, or
numba's for its kernels.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.render.array.by_numba import Host
from vividc.render import Camera, SceneError, psnr, read_scene, read_views, scaled_camera
from vividc.render.array import ArrayOptions, Device, Ledger
from vividc.render.array.march.batches import render_blocks
from vividc.render.array.march.depths import block_corners
from vividc.render.array.models.field import ArrayField
from vividc.render.array.pieces import SIDE, Piece
from vividc.render.array.records import Kept, Listed, Results, of_samples
from vividc.render.array.sampling import expected_samples, pixels_of, sampled
from vividc.render.radiance import (
    KiloNeRF,
    March,
    RadianceField,
    linear,
    occupied_samples,
    pixel_rays,
    render_field,
)
from vividc.render.splat.blend_reference import over_background

MIC = Path(__file__).parents[3] / "scenes" / "mic"


class HostField(ArrayField):
    """A reference model as an `ArrayField`."""

    def __init__(self, model: RadianceField, march: March | None = None) -> None:
        super().__init__(model, Host())
        self.model = model
        self.march = march or model.march

    def densities(self, listed: Listed) -> Results:
        thickness, _ = self.model.density(listed.points(), linear)
        reads = {"thickness": of_samples(thickness), "places": of_samples(order(listed.pieces))}
        return Results("transmittance_in_groups", reads)

    def colours(self, kept: Kept) -> Results:
        points, directions = kept.located()
        _, features = self.model.density(points, linear)
        rgb = self.model.colour(points, features, directions, linear)
        reads = {"colours": of_samples(rgb), "places": of_samples(order(kept.pieces))}
        return Results("accumulate_in_groups", reads)


def order(pieces: Sequence[Piece]) -> np.ndarray:
    """Each piece's samples one after the other."""
    return np.concatenate([np.arange(len(piece), dtype=np.int32) for piece in pieces])


@pytest.fixture
def host() -> Host:
    return Host()


@pytest.fixture(scope="session")
def model() -> KiloNeRF:
    return read_scene(MIC / "mic_kilonerf.npz")[1]


@pytest.fixture(scope="session")
def camera() -> Camera:
    return scaled_camera(read_views(MIC / "ref_kilo.npz")[0].camera, 20, 20)


def rendered(
    device: Device, field: HostField, camera: Camera, **options: bool | float
) -> tuple[np.ndarray, Ledger]:
    return render_blocks(
        device, field, camera, block_corners(camera), options=ArrayOptions(**options)
    )


@pytest.mark.slow  # the tests below have numba run the kernels
def test_the_picture_is_the_references_with_and_without_lookahead(
    device: Device, model: KiloNeRF, camera: Camera
) -> None:
    rgbt, expected = render_field(model, camera)
    image, on = rendered(device, HostField(model), camera)
    assert psnr(image, over_background(rgbt)) > 80
    late, off = rendered(device, HostField(model), camera, lookahead=False)
    np.testing.assert_array_equal(image, late)
    assert on.counts["rays"] == 400
    assert on.counts["density_samples"] == expected.density_samples
    assert on.counts["colour_samples"] == expected.colour_samples == off.counts["counted_samples"]
    assert off.counts["colour_samples"] == expected.density_samples
    assert list(on.stages) == [
        "block depths",
        "ray generation",
        "ray marching",
        "transmittance",
        "compaction",
        "accumulation",
    ]
    assert all(stage.cycles > 0 for stage in on.stages.values())


def test_colours_of_little_weight_are_left_out_as_the_reference_does(
    host: Host, model: KiloNeRF, camera: Camera
) -> None:
    rgbt, expected = render_field(model, camera, weight_min=0.01)
    image, on = rendered(host, HostField(model), camera, weight_min=0.01)
    late, off = rendered(host, HostField(model), camera, weight_min=0.01, lookahead=False)
    whole, every = rendered(host, HostField(model), camera)
    assert psnr(image, over_background(rgbt)) > 80
    assert 30 < psnr(image, whole) < 60
    np.testing.assert_array_equal(image, late)
    assert on.counts["colour_samples"] == expected.colour_samples == off.counts["counted_samples"]
    assert on.counts["colour_samples"] < 0.7 * every.counts["colour_samples"]


class FailingField(HostField):
    """It fails in its first batch."""

    fails = True

    def densities(self, listed: Listed) -> Results:
        if self.fails:
            raise SceneError("no density")
        return super().densities(listed)


def test_what_a_failed_frame_booked_is_in_no_other(
    host: Host, model: KiloNeRF, camera: Camera
) -> None:
    field = FailingField(model)
    with pytest.raises(SceneError, match="no density"):
        rendered(host, field, camera)
    field.fails = False
    assert rendered(host, field, camera)[1].counts == rendered(Host(), field, camera)[1].counts


def test_an_empty_scene_is_white(host: Host, model: KiloNeRF, camera: Camera) -> None:
    march = model.march
    empty = replace(march, occupied=np.zeros_like(march.occupied))
    image, ledger = rendered(host, HostField(model, empty), Camera(camera.c2w, 12.0, 9, 7))
    assert image.shape == (7, 9, 3)
    assert (image == 1).all()
    assert ledger.counts["rays"] == 63
    assert ledger.counts["empty_blocks"] == 2
    assert not ledger.stages


def test_a_dense_scene_is_marched_in_smaller_parts(
    host: Host, model: KiloNeRF, camera: Camera
) -> None:
    coarse = np.ones((3, 4, 5), dtype=np.bool_)
    march = replace(model.march, occupied=coarse)
    field = HostField(model, march)
    part = scaled_camera(camera, 8, 8)
    image, ledger = rendered(host, field, part)
    host = replace(model, march=march)
    rgbt, expected = render_field(host, part)
    assert ledger.counts["density_samples"] == expected.density_samples > 64 * 40
    assert psnr(image, over_background(rgbt)) > 80


def test_parts_are_no_larger_than_the_launches_behind_them(
    host: Host, model: KiloNeRF, camera: Camera
) -> None:
    full, step = np.ones((3, 4, 5), dtype=np.bool_), model.march.step / np.float32(4)
    finer = replace(model, march=replace(model.march, occupied=full, step=step, samples=1850))
    small = scaled_camera(camera, 4, 4)
    image, ledger = rendered(host, HostField(finer), small)
    rgbt, expected = render_field(finer, small)
    assert ledger.counts["density_samples"] == expected.density_samples
    assert psnr(image, over_background(rgbt)) > 80


def test_a_ray_of_more_samples_than_a_launch_has_room_for_is_rendered(
    host: Host, model: KiloNeRF, camera: Camera
) -> None:
    full, step = np.ones((3, 4, 5), dtype=np.bool_), model.march.step / np.float32(12)
    finer = replace(model, march=replace(model.march, occupied=full, step=step, samples=3000))
    small = scaled_camera(camera, 2, 2)
    image, ledger = rendered(host, HostField(finer), small)
    rgbt, expected = render_field(finer, small)
    assert ledger.counts["density_samples"] == expected.density_samples > 4 * 720
    assert psnr(image, over_background(rgbt)) > 80


def test_a_ray_of_many_steps_in_empty_cells_is_marched(
    host: Host, model: KiloNeRF, camera: Camera
) -> None:
    march = replace(model.march, step=model.march.step / np.float32(6), samples=20_000)
    finer = replace(model, march=march)
    small = scaled_camera(camera, 4, 4)
    image, ledger = rendered(host, HostField(finer), small)
    rgbt, expected = render_field(finer, small)
    assert ledger.counts["density_samples"] == expected.density_samples > 0
    assert psnr(image, over_background(rgbt)) > 80


def test_more_steps_than_samples_have_numbers_are_refused(
    host: Host, model: KiloNeRF, camera: Camera
) -> None:
    march = replace(model.march, samples=40_000)
    with pytest.raises(SceneError, match="a ray has 40000 steps, and the array numbers 32768"):
        rendered(host, HostField(model, march), camera)


def test_a_camera_inside_and_one_that_looks_away(
    host: Host, model: KiloNeRF, camera: Camera
) -> None:
    pose = camera.c2w.copy()
    pose[:3, 3] = (0.0, 0.1, 0.2)
    inside = Camera(pose, camera.focal, 8, 8)
    rgbt, expected = render_field(model, inside)
    image, ledger = rendered(host, HostField(model), inside)
    assert ledger.counts["density_samples"] == expected.density_samples
    assert psnr(image, over_background(rgbt)) > 80
    away = camera.c2w.copy()
    away[:3, :3] = away[:3, :3] @ np.diag([1, -1, -1]).astype(away.dtype)
    image, ledger = rendered(host, HostField(model), Camera(away, camera.focal, 8, 8))
    assert (image == 1).all()


def test_an_occupancy_that_fits_no_scratchpad_is_refused(
    host: Host, model: KiloNeRF, camera: Camera
) -> None:
    march = replace(model.march, occupied=np.ones((64, 64, 64), dtype=np.bool_))
    with pytest.raises(SceneError, match="64 x 64 x 64 cells takes 33792 bytes of a scratchpad"):
        rendered(host, HostField(model, march), camera)


def test_a_sample_is_the_same_blocks_each_time() -> None:
    camera = Camera(np.eye(4, dtype=np.float32), 100.0, 100, 60)
    corners = block_corners(camera)
    assert len(corners) == 13 * 8
    work = np.arange(104) % 7
    some = corners[sampled(work, 0.25)]
    assert len(some) == 26
    np.testing.assert_array_equal(some, corners[sampled(work, 0.25)])
    np.testing.assert_array_equal(sampled(work, 1.0), np.arange(104))
    assert len(sampled(work, 1e-9)) == 1
    assert pixels_of(corners, SIDE, camera).all()
    assert 0 < pixels_of(some, SIDE, camera).mean() < 0.3


@pytest.mark.parametrize("share", [0.05, 0.1, 0.3])
def test_a_sample_has_the_work_of_the_whole_picture(share: float) -> None:
    """The work of a picture lies in few blocks, and these beside each other."""
    row, column = np.mgrid[0:50, 0:50]
    work = np.where(np.hypot(row - 20, column - 30) < 12, 900 - (row * column) % 600, 0).ravel()
    assert work[sampled(work, share)].mean() == pytest.approx(work.mean(), rel=0.02)


def test_blocks_of_more_samples_are_expected_to_have_more(model: KiloNeRF, camera: Camera) -> None:
    corners = block_corners(camera)
    expected = expected_samples(model.march, camera, corners)
    rays = pixel_rays(camera, 0, camera.width * camera.height)
    ray = occupied_samples(model.march, camera.position, rays).ray
    block = ray // camera.width // SIDE * -(-camera.width // SIDE) + ray % camera.width // SIDE
    samples = np.bincount(block, minlength=len(corners))
    np.testing.assert_allclose(4 * expected, samples, atol=0.25 * samples.max())
    assert expected_samples(model.march, camera, corners[:0]).shape == (0,)
