"""A region as LLVM IR.

In order: `text`, `frame`; `operations` and `lanes` (what FUs compute); `body`, `loop`, `ending`.
"""
