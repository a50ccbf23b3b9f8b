"""Uses the installed package as a stranger would: `.ci/run` starts it outside the checkout."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np

import vividc
from vividc.render import orbit_camera, read_scene
from vividc.render.array import ArrayOptions, render_array
from vividc.render.array.device.kernels import all_kernels
from vividc.render.array.device.programs import Programs, kernel_folder


@vividc.kernel("void(float32[::1], float32[::1], int32)")
def saxpy(x, y, n):
    for i in range(n):
        y[i] += np.float32(2.0) * x[i]


def main(checkout: Path) -> None:
    """Compile, simulate and check saxpy, through Python and through the command line."""
    home = Path(vividc.__file__).resolve()
    if checkout.resolve() in home.parents:
        raise SystemExit(f"the checkout was imported, not the wheel: {home}")

    x = np.arange(64, dtype=np.float32)
    y = np.ones(64, dtype=np.float32)
    expected = y.copy()
    saxpy(x, expected, 64)
    program = vividc.compile(saxpy, fabric="vivid-tile")
    result = vividc.simulate(program, x, y, 64)
    vividc.view(program, "saxpy.html", (x, y, 64))  # needs the package's data
    np.testing.assert_array_equal(y, expected)

    program.save("saxpy.vivid")
    np.savez("in.npz", x=x, y=np.ones(64, dtype=np.float32), n=np.int32(64))
    command = [str(Path(sys.executable).parent / "vividc"), "simulate", "saxpy.vivid"]
    subprocess.run([*command, "--inputs", "in.npz", "--check"], check=True, timeout=120)

    os.environ["VIVIDC_CACHE_DIR"] = str(Path.cwd() / "cache")  # an empty one
    programs = Programs(vividc.arch.load_accelerator("vivid"))
    assert kernel_folder() == home.parent / "kernels"
    absent = [str(one) for one in all_kernels() if not programs.is_at_hand(one[0], **one[1])]
    assert not absent, f"not shipped: {', '.join(absent)}"
    for file in ("3dgs_sh3.ply", "kilonerf.npz", "ngp_hash.npz", "tensorf_vm.npz"):
        _, scene = read_scene(checkout / "scenes" / "mic" / f"mic_{file}")
        camera = orbit_camera(scene, 30.0, 20.0, "+z", 24, 24)
        told: list[str] = []
        frame = render_array(scene, camera, ArrayOptions(precision="fp8"), tell=told.append)
        assert not told, f"{file}: {told}"
        print(f"{file}: {frame.cycles} cycles, nothing compiled")

    iis = ", ".join(f"{region.name} II {region.ii}" for region in program.regions)
    print(f"wheel: saxpy in {result.cycles} cycles ({iis})")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
