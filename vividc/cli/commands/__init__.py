"""One module a command: `compile`, `opt`, `simulate`, `map`, `verify`, `view`, `disasm`, `area`,
`render`, `reproduce`, `list`."""
