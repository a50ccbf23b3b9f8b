"""Puts `kernels/` into the package: where it is installed, the renderers compile them."""

from setuptools import find_namespace_packages, setup

KERNELS = ("vividc.kernels", "vividc.kernels.render")

setup(
    packages=[*find_namespace_packages(include=["vividc*"]), *KERNELS],
    package_dir={"vividc.kernels": "kernels"},
)
