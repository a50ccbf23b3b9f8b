"""The renderers on the array: stages are compiled kernels, the host makes launch graphs."""
