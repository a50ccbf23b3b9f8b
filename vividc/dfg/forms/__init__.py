"""Graphs as text and data, in and out.

In order: `text` and `text_parser`; `json_form` with `json_fields` and `json_lines`; `dot` and
`dot_parser`; `morpher_xml`; `networkx_form`; what others call operations: `attributes`, `foreign`,
`foreign_json`; `load`, which picks a reader.
"""
