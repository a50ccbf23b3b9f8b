"""Mappers as published, on this project's fabrics: `upward` (their walk over IIs), `ims/`, `spr`,
`sat_kms`.
"""
