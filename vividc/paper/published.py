"""Figures that the ViViD paper and the platforms it compares with have published."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

METHODS: Final = ("kilonerf", "instant-ngp", "tensorf", "3dgs")
"""In the paper's order: MLP-based, hash grid, low rank, 3DGS."""
REAL_TIME_FPS: Final = 15.0
"""Section 1: 15 to 20 frames a second are interactive."""
SLOWEST_FPS, FASTEST_FPS = 16.5, 62.1
"""Section 5.3, of all methods at 800x800; which method has which is in a picture only."""
PSNR_LOSS_DB: Final = {"kilonerf": 0.20, "instant-ngp": 0.13, "tensorf": 0.38, "3dgs": 0.49}
"""Table 2: software (31.01, 30.85, 31.61, 34.47 dB) less ViViD (30.81, 30.72, 31.23, 33.98 dB)."""
SPEED_UP_OVER_NX: Final = {"kilonerf": 14.7, "instant-ngp": 18.2, "tensorf": 2.8, "3dgs": 9.7}
"""Table 3, Synthetic NeRF at 800x800, over a Jetson Orin NX."""
HARDWARE_SHARE: Final = {"kilonerf": 0.258, "instant-ngp": 0.653, "tensorf": 0.665, "3dgs": 0.843}
"""Figure 7(c): of the speed-up over the Orin NX; the rest is culling and formats."""
BREAKDOWN: Final[dict[tuple[str, str], tuple[float, float]]] = {
    ("kilonerf", "networks"): (0.90, 1.0),
    ("3dgs", "sorting"): (0.20, 0.35),
    ("3dgs", "blending"): (0.55, 0.75),
}
"""Section 2.1, shares of the time on an Orin NX, as ranges."""
POWER_W, AREA_MM2 = 3.94, 9.77
AREA_SHARES: Final = {"pe_array": 0.745, "sram": 0.226, "control": 0.029}
"""Figure 6, of 16 tiles at 45 nm and 1 GHz."""
MODES_SPEED_UP, UNIFIED_USE, PARTITIONED_USE = 1.34, 0.542, 0.727
"""Figure 8(a): a colour MLP on four 8x8 arrays over one 16x16 array, and their utilisations."""
EXP_SPEED_UP: Final = {"fp16": 1.27, "fp8": 1.56}
"""Figure 8(b): blending with exp in a format, over FP32."""
RELOAD_CYCLES: Final = 2560
"""Equations 4 and 5, of 256 PEs at an II of 10."""
SPEED_UP_BY_PIXELS: Final = {
    (800, "800x800"): {"kilonerf": 14.7, "instant-ngp": 18.2, "tensorf": 2.8, "3dgs": 9.7},
    (1024, "1264x832"): {"kilonerf": 16.5, "instant-ngp": 20.6, "tensorf": 3.4, "3dgs": 10.8},
    (1080, "1332x876"): {"kilonerf": 17.9, "instant-ngp": 22.1, "tensorf": 3.6, "3dgs": 11.6},
}
"""Table 3: over an Orin NX, by the side of a square of about as many pixels, and their size."""


@dataclass(frozen=True, slots=True)
class Platform:
    """A published renderer: frames a second, or pixels; None: not published.

    Attributes
    ----------
    process_nm
        Of the technology.
    pixels_per_second, watts
        As published, on the scenes of its own publication.
    """

    name: str
    renders: str
    process_nm: float | None
    pixels_per_second: float | None
    watts: float | None
    source: str

    @property
    def pixels_per_joule(self) -> float | None:
        """None where one of both is not published."""
        if self.pixels_per_second is None or self.watts is None:
            return None
        return self.pixels_per_second / self.watts


PLATFORMS: Final = (
    Platform("Jetson Orin NX", "all", 8, None, 25, "10 to 25 W; the paper gives ratios to it only"),
    Platform("Jetson Nano", "all", 20, None, 10, "10 W; the paper gives ratios to it only"),
    Platform("Uni-Render", "all", None, None, 5, "HPCA 2025: above 30 frames a second, about 5 W"),
    Platform("MetaVRain", "KiloNeRF's kind", 28, 118 * 800 * 800, None, "at most 118 frames"),
    Platform("NeuGPU", "Instant-NGP", 28, None, None, "20.25 mm2"),
    Platform("RT-NeRF", "TensoRF", None, None, None, "ICCAD 2022: 9.7x to 3,201x its baselines"),
    Platform("ICARUS", "NeRF", 40, None, 0.2828, "TOG 2022: a core of 16.5 mm2 at 400 MHz"),
    Platform("GSCore", "3DGS", 28, None, None, "ASPLOS 2024: 15.86x a mobile GPU"),
    Platform(
        *("Chang and Chang", "3DGS", 28, 267.5e6, 0.219),
        "arXiv 2604.10223, 2026: 1080p at 129 frames a second, 0.66 mm2 at 800 MHz, models pruned",
    ),
)
