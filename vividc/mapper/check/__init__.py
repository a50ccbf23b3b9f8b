"""The verifier and the check of certificates: written from docs/machine.md, sharing no line with a
mapper.

In order: `case` and `finding` (what is looked at, what is reported), `routes`, `verify` (is a
mapping legal); `reach`, `bounds`, `lives`, `objective`, `certificate` (does a result prove what it
claims).
"""
