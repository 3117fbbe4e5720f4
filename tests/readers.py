"""Read an output file with its format's own reader and compare it with what was to be written.

    readers.py mat FILE EXPECTED    FILE by scipy.io.loadmat
    readers.py vts FILE EXPECTED    FILE by VTK through pyvista
    readers.py streamed FOLDER MAT  compliance.npy and compliance.mat of a streamed map in FOLDER by
                                    numpy.load and as MATLAB's memmapfile maps it, against the whole
                                    map in MAT

EXPECTED is JSON. An array is {"shape": [...], "re": [...], "im": [...]} with the last index
fastest ("im" only for complex ones), a text a string, a cell array {"cells": [...]} (a column),
a struct array {"structs": [{field: value}, ...]} (a row). Numbers must agree to the last bit.
Exit code 0 if all agree, 1 with the first difference, 2 if the call is wrong.
"""

import json
import sys

import numpy as np


class Difference(Exception):
    """What differs, and where."""


def compare(name, seen, expected):
    if isinstance(expected, str):
        text = "" if seen.size == 0 else str(seen.reshape(-1)[0])
        if text != expected:
            raise Difference(f"{name}: {text!r}, expected {expected!r}")
    elif "cells" in expected:
        cells = expected["cells"]
        shape(name, seen, [len(cells), 1])
        for i, cell in enumerate(cells):
            compare(f"{name}{{{i}}}", seen[i, 0], cell)
    elif "structs" in expected:
        structs = expected["structs"]
        shape(name, seen, [1, len(structs)])
        for i, fields in enumerate(structs):
            if sorted(seen.dtype.names) != sorted(fields):
                raise Difference(f"{name}: fields {seen.dtype.names}, expected {list(fields)}")
            for field, value in fields.items():
                compare(f"{name}({i}).{field}", seen[0, i][field], value)
    else:
        shape(name, seen, expected["shape"])
        wanted = np.array(expected["re"], dtype=float)
        if "im" in expected:
            wanted = wanted + 1j * np.array(expected["im"], dtype=float)
        if np.iscomplexobj(seen) != np.iscomplexobj(wanted):
            raise Difference(f"{name}: {seen.dtype}, expected {wanted.dtype}")
        wanted = wanted.reshape(expected["shape"])
        for place in np.argwhere(seen != wanted):
            place = tuple(int(i) for i in place)
            raise Difference(f"{name}{list(place)}: {seen[place]}, expected {wanted[place]}")


def shape(name, seen, expected):
    if list(seen.shape) != list(expected):
        raise Difference(f"{name}: shape {list(seen.shape)}, expected {list(expected)}")


def mat(path, expected):
    from scipy.io import loadmat

    seen = {k: v for k, v in loadmat(path).items() if not k.startswith("__")}
    if sorted(seen) != sorted(expected):
        raise Difference(f"variables {sorted(seen)}, expected {sorted(expected)}")
    for name, value in expected.items():
        compare(name, seen[name], value)


def vts(path, expected):
    import pyvista

    grid = pyvista.read(path)
    if str(grid.field_data["unit"][0]) != expected.pop("unit"):
        raise Difference(f"unit: {grid.field_data['unit']}")
    compare("dimensions", np.array(grid.dimensions, dtype=float), expected.pop("dimensions"))
    compare("bounds", np.array(grid.bounds, dtype=float), expected.pop("bounds"))
    for name, value in expected.items():
        compare(name, np.asarray(grid.point_data[name]), value)


def streamed(folder, whole):
    import os

    from scipy.io import loadmat

    whole = loadmat(whole)
    axes = loadmat(os.path.join(folder, "compliance.mat"))
    for name in ("position_m", "frequency_hz", "output", "input", "quantity", "unit"):
        if not np.array_equal(axes[name], whole[name]):
            raise Difference(f"{name}: {axes[name]}, expected {whole[name]}")
    quantity = str(whole["quantity"][0])
    expected = whole[quantity]
    file = os.path.join(folder, str(axes["file"][0]))
    seen = np.load(file, mmap_mode="r")
    shape(quantity, seen, expected.shape)
    shape(quantity, seen, axes["shape"][0].astype(int))
    if seen.dtype != np.complex128 or not np.array_equal(seen, expected):
        raise Difference(f"{quantity}: {seen.dtype}, values differ")
    # memmapfile(file, 'Offset', offset_bytes, 'Format', {'double', [2 fliplr(shape)], 'h'}), first index fastest.
    extents = (2, *reversed(expected.shape))
    h = np.memmap(file, dtype=float, mode="r", offset=int(axes["offset_bytes"][0, 0]), shape=extents, order="F")
    if h.size * 8 + int(axes["offset_bytes"][0, 0]) != os.path.getsize(file):
        raise Difference(f"{file}: {os.path.getsize(file)} bytes")
    parts = np.transpose(h, (0, 4, 3, 2, 1))
    if not (np.array_equal(parts[0], expected.real) and np.array_equal(parts[1], expected.imag)):
        raise Difference(f"{quantity}: values differ as memmapfile maps them")


def main(arguments):
    if len(arguments) == 3 and arguments[0] == "streamed":
        try:
            streamed(*arguments[1:])
        except Difference as difference:
            print(difference, file=sys.stderr)
            return 1
        return 0
    readers = {"mat": mat, "vts": vts}
    if len(arguments) != 3 or arguments[0] not in readers:
        print(__doc__, file=sys.stderr)
        return 2
    kind, path, expected = arguments
    with open(expected, encoding="utf-8") as file:
        wanted = json.load(file)
    try:
        readers[kind](path, wanted)
    except Difference as difference:
        print(difference, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
