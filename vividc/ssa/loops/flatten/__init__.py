"""A nest becomes one loop: `rotate`, `rectangle`, `indices`, and `flatten` itself."""
