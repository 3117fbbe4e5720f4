"""Writes the OUTPUT4 files beside this script as the NX Nastran DMAP Programmer's Guide describes module
OUTPUT4, and has pyNastran's reader confirm each (pip install pyNastran==1.4.1 "numpy<2" scipy).

KAA is the tridiagonal matrix of a chain of springs (2e9 on the diagonal, -1e9 beside it), MAA a diagonal of
row numbers over 7, both of order 9; PHI is 2 x 3. tests/matrices/readers.rs knows them by these formulas.
"""

import struct
from pathlib import Path

import numpy as np
from pyNastran.op4.op4 import read_op4

ORDER = 9
MATRICES = {
    "KAA": (6, 2e9 * np.eye(ORDER) - 1e9 * (np.eye(ORDER, k=1) + np.eye(ORDER, k=-1))),
    "MAA": (6, np.diag(np.arange(1, ORDER + 1) / 7.0)),
    "PHI": (2, np.arange(1.0, 7.0).reshape(2, 3)),
}


def strings(column):
    """Runs of values that are not zero: (first row from 1, values)."""
    runs = []
    for row, value in enumerate(column, 1):
        if value == 0:
            continue
        if runs and runs[-1][0] + len(runs[-1][1]) == row:
            runs[-1][1].append(value)
        else:
            runs.append((row, [value]))
    return runs


def text(sparse, big, double):
    digits, words = (16, 2) if double else (9, 1)
    width, per_line = digits + 7, 80 // (digits + 7)
    out = []

    def values(numbers):
        for k in range(0, len(numbers), per_line):
            out.append("".join(f"{v:{width}.{digits}E}" for v in numbers[k : k + per_line]))

    for name, (form, matrix) in MATRICES.items():
        rows, columns = matrix.shape
        out.append(f"{columns:8d}{-rows if big else rows:8d}{form:8d}{2 if double else 1:8d}{name:8s}1P,{per_line}E{width}.{digits}")
        for icol, column in enumerate(matrix.T, 1):
            runs = strings(column)
            if sparse:
                own = 2 if big else 1
                out.append(f"{icol:8d}{0:8d}{sum(own + words * len(v) for _, v in runs):8d}")
                for row, run in runs:
                    length = words * len(run)
                    out.append(f"{length + 1:8d}{row:8d}" if big else f"{row + 65536 * (length + 1):12d}")
                    values(run)
            else:
                first, last = runs[0][0], runs[-1][0] + len(runs[-1][1]) - 1
                out.append(f"{icol:8d}{first:8d}{words * (last - first + 1):8d}")
                values(list(column[first - 1 : last]))
        out.append(f"{columns + 1:8d}{1:8d}{1:8d}")
        values([1.0])
    return "\n".join(out).encode() + b"\n"


def binary(sparse, big, double, order="<"):
    words, real = (2, "d") if double else (1, "f")
    out = b""

    def record(payload):
        return struct.pack(order + "i", len(payload)) + payload + struct.pack(order + "i", len(payload))

    for name, (form, matrix) in MATRICES.items():
        rows, columns = matrix.shape
        head = struct.pack(order + "4i", columns, -rows if big else rows, form, 2 if double else 1)
        out += record(head + f"{name:8s}".encode())
        for icol, column in enumerate(matrix.T, 1):
            runs = strings(column)
            data = b""
            if sparse:
                first = 0
                for row, run in runs:
                    length = words * len(run)
                    data += struct.pack(order + "2i", length + 1, row) if big else struct.pack(order + "i", row + 65536 * (length + 1))
                    data += struct.pack(f"{order}{len(run)}{real}", *run)
            else:
                first, last = runs[0][0], runs[-1][0] + len(runs[-1][1]) - 1
                data = struct.pack(f"{order}{last - first + 1}{real}", *column[first - 1 : last])
            out += record(struct.pack(order + "3i", icol, first, len(data) // 4) + data)
        out += record(struct.pack(order + "3i", columns + 1, 1, words) + struct.pack(order + real, 1.0))
    return out


for storage, sparse, big in [("dense", False, False), ("sparse", True, False), ("bigmat", True, True)]:
    for double in (False, True):
        precision = "double" if double else "single"
        files = {f"{storage}_text_{precision}": text(sparse, big, double), f"{storage}_binary_{precision}": binary(sparse, big, double)}
        if storage == "sparse":
            files[f"{storage}_binary_{precision}_big_endian"] = binary(sparse, big, double, ">")
        for name, content in files.items():
            file = Path(__file__).parent / f"{name}.op4"
            file.write_bytes(content)
            read = read_op4(str(file), debug=False)
            for key, (_, matrix) in MATRICES.items():
                seen = read[key].data
                seen = seen.toarray() if hasattr(seen, "toarray") else seen
                assert np.allclose(seen, matrix, rtol=1e-6 if not double else 1e-15), (name, key, seen)
            print(name, len(content), "confirmed")
