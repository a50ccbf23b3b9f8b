"""LLVM in a process of its own, for text that others wrote.

A `.ll` file can make LLVM's parser overflow its stack or end the process, and a compiled kernel can
do anything: neither happens in the user's Python. `client` starts one small server a process, which
imports llvmlite and none of vividc's other packages; it forks for each request, so that what a
request breaks is gone with it. A request is `work`'s.

In order: `messages`, `work`, `server`, `client`.
"""
