"""C as LLVM IR that clang wrote.

In order: `source`, `places`, `debug` (the text, lines and types), `checks`, `library` (C's
functions), `entry`, `unrotate`, `lower`; `reference` and `host` (the kernel on the host), `kernel`
(`load_ll`).
"""
