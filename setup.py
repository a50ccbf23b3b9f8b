"""Puts `kernels/` into the package: where it is installed, the renderers compile them.

The script's module is added by name: it must be importable without the package.
"""

from setuptools import find_namespace_packages, setup

KERNELS = ("vividc.kernels", "vividc.kernels.render")

setup(
    packages=[*find_namespace_packages(include=["vividc*"]), *KERNELS],
    package_dir={"vividc.kernels": "kernels"},
    py_modules=["vividc_main"],
)
