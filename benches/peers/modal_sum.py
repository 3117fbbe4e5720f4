"""The compliance map by NumPy and JAX, beside `stiffmap bench`, in one run.

    python -m venv .venv && .venv/bin/pip install -r benches/peers/requirements.txt
    cargo build --release
    .venv/bin/python benches/peers/modal_sum.py

H[p, k, i, j] = sum_r L[p, i, r] L[p, j, r] / (omega_r^2 - omega_k^2 + 2 j zeta_r omega_r omega_k), outputs = inputs.

Each form is run once (which compiles it), checked against the first, and then timed; the median counts. JAX waits for
its result. Ours is measured again before each form; the ratio is the form's time over that.
"""

import argparse
import json
import statistics
import subprocess
import sys
import time

import numpy as np

TAU = 2.0 * np.pi
ZETA = 0.02


def model(positions, frequencies, modes, ports):
    """Natural frequencies (rad/s), shapes and grid (rad/s), as src/gpu/bench/case.rs makes them."""
    p, r, i = np.arange(positions), np.arange(modes), np.arange(ports)
    omega_r = TAU * (14.1 + 29.3 * r[None, :] + 1e-3 * p[:, None])
    shapes = 0.05 * np.sin(1.7 * (1 + i[None, :, None] + 3 * r[None, None, :] + 7 * p[:, None, None]))
    omega = TAU * 900.0 * np.arange(frequencies) / frequencies
    return omega_r, shapes, omega


def numpy_loop(omega_r, shapes, omega):
    """A loop over positions; residues times weights as one matrix product."""
    n_p, n_i, n_r = shapes.shape
    h = np.empty((n_p, omega.size, n_i, n_i), dtype=complex)
    for p in range(n_p):
        residues = (shapes[p][:, None, :] * shapes[p][None, :, :]).reshape(n_i * n_i, n_r)
        d = omega_r[p] ** 2 - omega[:, None] ** 2 + 2j * ZETA * omega_r[p] * omega[:, None]
        np.matmul(1.0 / d, residues.T, out=h[p].reshape(omega.size, n_i * n_i))
    return h


def numpy_real(omega_r, shapes, omega):
    """As numpy_loop in real arithmetic and without temporaries: NumPy divides complex numbers slowly."""
    n_p, n_i, n_r = shapes.shape
    h = np.empty((n_p, omega.size, n_i, n_i), dtype=complex)
    u, v, n, s = (np.empty((omega.size, n_r)) for _ in range(4))
    for p in range(n_p):
        residues = (shapes[p][:, None, :] * shapes[p][None, :, :]).reshape(n_i * n_i, n_r).T
        np.subtract.outer(-(omega**2), -(omega_r[p] ** 2), out=u)
        np.multiply.outer(omega, -2.0 * ZETA * omega_r[p], out=v)
        np.multiply(u, u, out=n)
        n += np.multiply(v, v, out=s)
        np.divide(1.0, n, out=n)
        u *= n
        v *= n
        rows = h[p].reshape(omega.size, n_i * n_i)
        rows.real = u @ residues
        rows.imag = v @ residues
    return h


def numpy_einsum(omega_r, shapes, omega):
    """One einsum over everything, its order of contraction optimised."""
    d = omega_r[:, None, :] ** 2 - omega[None, :, None] ** 2 + 2j * ZETA * omega_r[:, None, :] * omega[None, :, None]
    return np.einsum("pkr,pir,pjr->pkij", 1.0 / d, shapes, shapes, optimize=True)


def jax_form(real):
    """The same einsum under jax.jit in `real` precision."""
    import jax
    import jax.numpy as jnp

    jax.config.update("jax_enable_x64", True)
    complex_type = jnp.complex64 if real == jnp.float32 else jnp.complex128

    @jax.jit
    def compute(omega_r, shapes, omega):
        residues = shapes[:, :, None, :] * shapes[:, None, :, :]
        d = (omega_r[:, None, :] - omega[None, :, None]) * (omega_r[:, None, :] + omega[None, :, None])
        v = 2.0 * ZETA * omega_r[:, None, :] * omega[None, :, None]
        weights = (1.0 / jax.lax.complex(d, v)).astype(complex_type)
        return jnp.einsum("pkr,pijr->pkij", weights, residues.astype(complex_type))

    return lambda *arguments: compute(*(jnp.asarray(a, dtype=real) for a in arguments)).block_until_ready()


def median_seconds(form, arguments, repetitions):
    seconds = []
    for _ in range(repetitions):
        start = time.perf_counter()
        form(*arguments)
        seconds.append(time.perf_counter() - start)
    return statistics.median(seconds)


def forms():
    yield "NumPy, loop with matmul, f64", numpy_loop, 1e-10
    yield "NumPy, loop with matmul in real arithmetic, f64", numpy_real, 1e-10
    yield "NumPy, einsum, f64", numpy_einsum, 1e-10
    try:
        import jax.numpy as jnp
    except ImportError:
        print("JAX is not installed: left out", file=sys.stderr)
        return
    yield "JAX, jit, f32", jax_form(jnp.float32), 1e-2
    yield "JAX, jit, f64", jax_form(jnp.float64), 1e-10


def ours(command, sizes):
    arguments = [a for name, value in sizes.items() for a in (f"--{name}", str(value))]
    output = subprocess.run([*command.split(), *arguments], check=True, capture_output=True, text=True).stdout
    return json.loads(output)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--positions", type=int, default=121)
    parser.add_argument("--frequencies", type=int, default=2000)
    parser.add_argument("--modes", type=int, default=30)
    parser.add_argument("--repetitions", type=int, default=10)
    parser.add_argument("--ours", default="target/release/stiffmap bench --backend cpu --json", help="our command")
    arguments = parser.parse_args()
    sizes = {name: getattr(arguments, name) for name in ("positions", "frequencies", "modes")}

    rows = []
    inputs = model(*sizes.values(), ports=3)
    reference = None
    for name, form, tolerance in forms():
        result = np.asarray(form(*inputs))
        reference = result if reference is None else reference
        difference = np.linalg.norm(result - reference) / np.linalg.norm(reference)
        if not difference <= tolerance:
            sys.exit(f"{name}: relative difference {difference:.1e} from the first form, allowed {tolerance:.0e}")
        # Ours again beside each form: on a machine with other work both see the same of it.
        [own, *_] = ours(arguments.ours, sizes)
        rows.append((name, median_seconds(form, inputs, arguments.repetitions), own["median_seconds"]))

    print(", ".join(f"{value} {name}" for name, value in sizes.items()), "and 3 x 3 values")
    print(f"stiffmap, {own['backend']}, {own['precision']} ({own['device']})")
    print(f"{'':58} {'median ms':>10} {'ours ms':>8} {'ratio':>7}")
    for name, seconds, own_seconds in rows:
        print(f"{name:58} {1e3 * seconds:10.2f} {1e3 * own_seconds:8.2f} {seconds / own_seconds:7.2f}")


if __name__ == "__main__":
    main()
