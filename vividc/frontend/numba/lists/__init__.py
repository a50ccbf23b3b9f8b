"""Lists of a kernel, whose heap the array has not.

In order: `fixed` (of fixed length: tuples and arrays), `growing` (an array with a length), `kept`
(what no iteration may hand on).
"""
