"""One module a command: `compile`, `simulate`, `map`, `verify`, `disasm`, `area`, `render`."""
