"""Programs from `.vivid` files and their bytes. Nothing in one is executed."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

import numpy as np

from vividc.arch import load_text
from vividc.errors import BundleError, VividcError, demand_type
from vividc.program.bundle import BundleReader, Manifest
from vividc.program.faults import faults
from vividc.program.program import Program, opcode_names
from vividc.program.words.layout import word_layout


def load(path: str | os.PathLike[str]) -> Program:
    """Read a `.vivid` file. Nothing in the file is executed.

    Raises
    ------
    BundleError
        The file is missing, damaged, of another version, or inconsistent; it names the path.
    """
    demand_type(path, (str, os.PathLike), "the path", "give a string or a pathlib.Path")
    return _read(BundleReader(Path(path)))


def from_bytes(data: bytes) -> Program:
    """Read what `Program.to_bytes` gave.

    Raises
    ------
    BundleError
        It is damaged, of another version, or inconsistent.
    """
    return _read(BundleReader(Path("kept program"), data))


def _read(bundle: BundleReader) -> Program:
    with bundle as reader:
        manifest = reader.manifest()
        program = _assemble(reader, manifest)
        for fault in faults(program):
            raise BundleError(fault)
        return program


def _read_nests(reader: BundleReader, manifest: Manifest) -> tuple[Program, ...]:
    nests = []
    for number, data in enumerate(reader.nests(manifest.nests)):
        inner = BundleReader(Path(f"{reader.path}, nest {number}"), data)
        with inner as opened:
            if opened.manifest().nests:  # one in another, and so on, would be read without end
                raise BundleError("a nest of it has nests of its own")
        nests.append(_read(inner))
    return tuple(nests)


def _assemble(reader: BundleReader, manifest: Manifest) -> Program:
    if manifest.opcodes != opcode_names():
        raise BundleError(
            "the program was made with another opcode table",
            hint="compile the kernel again with this version",
        )
    try:
        fabric = load_text(manifest.fabric, str(reader.path))
    except VividcError as error:
        raise BundleError(f"its fabric cannot be read: {error.reason}") from error
    pes = len(fabric.pes)
    words = (manifest.contexts, pes, word_layout(fabric).words_per_entry)
    images = (pes, max(pe.constants for pe in fabric.pes))
    return Program(
        name=manifest.name,
        params=manifest.params,
        returns=manifest.returns,
        fabric=fabric,
        words=reader.array("words", np.dtype(np.uint32), words),
        table=manifest.table,
        images=reader.array("images", np.dtype(np.uint32), images),
        images_set=reader.array("images_set", np.dtype(np.bool_), images),
        launch=manifest.launch,
        return_home=manifest.return_home,
        return_high=manifest.return_high,
        banks=manifest.banks,
        pitches=manifest.pitches,
        nests=_read_nests(reader, manifest),
        order=manifest.order,
        accelerator=manifest.accelerator,
        results=manifest.results,
        debug=manifest.debug,
        regions=tuple(replace(row, fabric_yaml=manifest.fabric) for row in manifest.regions),
        provenance=manifest.provenance,
        warnings=manifest.warnings,
        locals=manifest.locals,
        loops=manifest.loops,
        parallel=manifest.parallel,
        products=manifest.products,
    )
