// Eigenvalues of a symmetric matrix and some rows times its eigenvectors, without the eigenvectors themselves:
// Householder tridiagonalisation and implicit QL, the rotations applied to the rows alone. Source: Wilkinson, Reinsch,
// Handbook for Automatic Computation II, 1971 (tred2, tql2). The matrix is ordered with its large entries last.

// a: n x n, its lower triangle is used up. rows: m x n, replaced. Returns the eigenvalues, unordered, in d.
// space: three arrays of n. Four rows at a time: each number that is loaded serves four.
function eigenRows(n, a, rows, m, d, space) {
  const [e, work, u] = space;
  for (let k = n - 1; k > 0; k--) {
    const at = k * n;
    let rest = 0;
    for (let j = 0; j < k - 1; j++) {
      u[j] = a[at + j];
      rest += u[j] * u[j];
    }
    const last = a[at + k - 1];
    d[k] = a[at + k];
    if (rest === 0) {
      e[k - 1] = last;
      continue;
    }
    const norm = Math.sqrt(rest + last * last);
    const alpha = last > 0 ? -norm : norm;
    e[k - 1] = alpha;
    u[k - 1] = last - alpha;
    // The leading block times I - u u^T / h from both sides, the rows from the right.
    const h = norm * norm - alpha * last;
    multiply(n, k, a, u, work);
    let scale = 0;
    for (let i = 0; i < k; i++) {
      work[i] /= h;
      scale += work[i] * u[i];
    }
    scale /= 2 * h;
    for (let i = 0; i < k; i++) work[i] -= scale * u[i];
    subtract(n, k, a, u, work);
    for (let r = 0; r < m; r++) {
      const row = r * n;
      let product = 0;
      for (let j = 0; j < k; j++) product += rows[row + j] * u[j];
      product /= h;
      for (let j = 0; j < k; j++) rows[row + j] -= product * u[j];
    }
  }
  d[0] = a[0];
  e[n - 1] = 0;
  implicitQl(n, d, e, rows, m);
}

// work = A u for the leading k x k block, of which the lower triangle is there.
function multiply(n, k, a, u, work) {
  work.fill(0, 0, k);
  let i = 0;
  for (; i + 3 < k; i += 4) {
    const [r0, r1, r2, r3] = [i * n, (i + 1) * n, (i + 2) * n, (i + 3) * n];
    const [u0, u1, u2, u3] = [u[i], u[i + 1], u[i + 2], u[i + 3]];
    let [s0, s1, s2, s3] = [0, 0, 0, 0];
    for (let j = 0; j < i; j++) {
      const uj = u[j];
      const a0 = a[r0 + j];
      const a1 = a[r1 + j];
      const a2 = a[r2 + j];
      const a3 = a[r3 + j];
      s0 += a0 * uj;
      s1 += a1 * uj;
      s2 += a2 * uj;
      s3 += a3 * uj;
      work[j] += a0 * u0 + a1 * u1 + a2 * u2 + a3 * u3;
    }
    const [b10, b20, b21] = [a[r1 + i], a[r2 + i], a[r2 + i + 1]];
    const [b30, b31, b32] = [a[r3 + i], a[r3 + i + 1], a[r3 + i + 2]];
    work[i] += s0 + a[r0 + i] * u0 + b10 * u1 + b20 * u2 + b30 * u3;
    work[i + 1] += s1 + b10 * u0 + a[r1 + i + 1] * u1 + b21 * u2 + b31 * u3;
    work[i + 2] += s2 + b20 * u0 + b21 * u1 + a[r2 + i + 2] * u2 + b32 * u3;
    work[i + 3] += s3 + b30 * u0 + b31 * u1 + b32 * u2 + a[r3 + i + 3] * u3;
  }
  for (; i < k; i++) {
    const row = i * n;
    let sum = a[row + i] * u[i];
    for (let j = 0; j < i; j++) {
      sum += a[row + j] * u[j];
      work[j] += a[row + j] * u[i];
    }
    work[i] += sum;
  }
}

// A - u w^T - w u^T in the lower triangle of the leading k x k block; what lies above the diagonal is not read.
function subtract(n, k, a, u, w) {
  let i = 0;
  for (; i + 3 < k; i += 4) {
    const [r0, r1, r2, r3] = [i * n, (i + 1) * n, (i + 2) * n, (i + 3) * n];
    const [u0, u1, u2, u3] = [u[i], u[i + 1], u[i + 2], u[i + 3]];
    const [w0, w1, w2, w3] = [w[i], w[i + 1], w[i + 2], w[i + 3]];
    for (let j = 0; j < i + 4; j++) {
      const uj = u[j];
      const wj = w[j];
      a[r0 + j] -= u0 * wj + w0 * uj;
      a[r1 + j] -= u1 * wj + w1 * uj;
      a[r2 + j] -= u2 * wj + w2 * uj;
      a[r3 + j] -= u3 * wj + w3 * uj;
    }
  }
  for (; i < k; i++) {
    const row = i * n;
    for (let j = 0; j <= i; j++) a[row + j] -= u[i] * w[j] + w[i] * u[j];
  }
}

function implicitQl(n, d, e, rows, m) {
  for (let l = 0; l < n; l++) {
    for (let step = 0; ; step++) {
      let q = l;
      while (q < n - 1 && Math.abs(e[q]) > 2.3e-16 * (Math.abs(d[q]) + Math.abs(d[q + 1]))) q++;
      if (q === l) break;
      if (step > 80) throw new Error("the eigenvalues of a position did not converge");
      let g = (d[l + 1] - d[l]) / (2 * e[l]);
      const root = Math.hypot(g, 1);
      g = d[q] - d[l] + e[l] / (g + (g >= 0 ? root : -root));
      let s = 1;
      let c = 1;
      let p = 0;
      let i = q - 1;
      for (; i >= l; i--) {
        const f = s * e[i];
        const b = c * e[i];
        let r = Math.sqrt(f * f + g * g);
        e[i + 1] = r;
        if (r === 0) {
          d[i + 1] -= p;
          e[q] = 0;
          break;
        }
        s = f / r;
        c = g / r;
        g = d[i + 1] - p;
        r = (d[i] - g) * s + 2 * c * b;
        p = s * r;
        d[i + 1] = g + p;
        g = c * r - b;
        for (let k = 0, at = i; k < m; k++, at += n) {
          const x = rows[at];
          const y = rows[at + 1];
          rows[at + 1] = s * x + c * y;
          rows[at] = c * x - s * y;
        }
      }
      if (i >= l) continue;
      d[l] -= p;
      e[l] = g;
      e[q] = 0;
    }
  }
}
