"""Loop transformations on kernels in SSA form, before regions are cut."""
