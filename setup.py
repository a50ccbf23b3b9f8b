"""Puts `kernels/` into the package: the renderers on the array compile them at their users'."""

from setuptools import find_namespace_packages, setup

KERNELS = ("vividc.kernels", "vividc.kernels.render")

setup(
    packages=[*find_namespace_packages(include=["vividc*"]), *KERNELS],
    package_dir={"vividc.kernels": "kernels"},
)
