"""What loops are written with. In order: `accessed` (places that code loads, stores, computes),
`words` (integers as instructions), `registers` (values of places, loads and stores).
"""
