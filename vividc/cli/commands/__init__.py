"""One module a command: `compile`, `opt`, `simulate`, `map`, `verify`, `disasm`, `area`,
`render`, `reproduce`, `list`."""
