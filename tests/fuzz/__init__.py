"""Random kernels against numba, with shrinking: `python -m tests.fuzz`."""
