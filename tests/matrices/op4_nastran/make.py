"""Writes the OUTPUT4 texts *.op4 beside this script as Nastran writes them, by pyYeti's writer, and has its
reader confirm them (pip install pyyeti==1.4.7).

KAA is the tridiagonal matrix of a chain of springs (2e9 on the diagonal, -1e9 beside it) with a spring from the first
row to the last (-1, so that columns have several strings), MAA a diagonal of row numbers over 7 without the third,
whose column is not written; both of order 9. CPH is complex, 3 x 2. tests/matrices/nastran.rs knows them by these
formulas.
"""

from pathlib import Path

import numpy as np
from pyyeti.nastran import op4

ORDER = 9
KAA = 2e9 * np.eye(ORDER) - 1e9 * (np.eye(ORDER, k=1) + np.eye(ORDER, k=-1))
KAA[0, -1] = KAA[-1, 0] = -1.0
MAA = np.diag(np.arange(1, ORDER + 1) / 7.0)
MAA[2, 2] = 0.0
CPH = np.arange(1.0, 7.0).reshape(3, 2) * (1 + 2j)

for storage in ("dense", "bigmat", "nonbigmat"):
    for digits in (9, 16):
        file = Path(__file__).parent / f"{storage}_{digits}.op4"
        names, matrices = ["CPH", "KAA", "CPX", "MAA"], [CPH, KAA, CPH[:2], MAA]
        op4.write(str(file), names, matrices, binary=False, digits=digits, sparse=storage, forms=[2, 6, 2, 6])
        read = op4.read(str(file))
        for name, matrix in [("kaa", KAA), ("maa", MAA), ("cph", CPH)]:
            assert np.allclose(read[name], matrix, rtol=10.0**-digits), (file, name)
        print(file.name, "confirmed")
