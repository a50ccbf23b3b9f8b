"""The mic scene, read and projected once a session."""

from __future__ import annotations

from pathlib import Path

import pytest

from vividc.render import Camera, Gaussians, TileLists, load_cameras, read_gaussians, tile_lists

MIC = Path(__file__).parents[2] / "scenes" / "mic"


@pytest.fixture(scope="session")
def mic_views() -> Path:
    return MIC / "ref_gs.npz"


@pytest.fixture(scope="session")
def mic() -> Gaussians:
    return read_gaussians(MIC / "mic_3dgs_sh3.ply")


@pytest.fixture(scope="session")
def mic_cameras(mic_views: Path) -> tuple[Camera, ...]:
    return load_cameras(mic_views)


@pytest.fixture(scope="session")
def mic_tiles(mic: Gaussians, mic_cameras: tuple[Camera, ...]) -> TileLists:
    return tile_lists(mic, mic_cameras[0])
