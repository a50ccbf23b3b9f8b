"""Random kernels against numba, with shrinking: `python -m tests.fuzz`."""

import os

os.environ.setdefault("VIVIDC_CACHE_PROGRAMS", "0")  # no random programs in the user's cache
