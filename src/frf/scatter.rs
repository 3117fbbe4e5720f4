//! From sums in registers' order to the map's order.

use nalgebra::Complex;

/// Values of a map from which on it is written past the caches (4 MiB): a larger one would leave them anyway, and
/// writing past them saves reading each line first.
pub(super) const LARGE: usize = 1 << 18;

/// One vector's sums `[pair, lane]` into rows `[frequency, value]`, as many as there are.
///
/// With `stream` rows are written past the caches where the processor can; [`finish`] must follow.
#[inline(always)]
pub(super) fn scatter(
    sums: &[Complex<f64>],
    pair_of_value: &[usize],
    lanes: usize,
    stream: bool,
    values: &mut [Complex<f64>],
) {
    match (pair_of_value.len(), stream && values.as_ptr().addr().is_multiple_of(16)) {
        (9, true) => rows::<9, true>(sums, pair_of_value, lanes, values),
        (9, false) => rows::<9, false>(sums, pair_of_value, lanes, values),
        (1, true) => rows::<1, true>(sums, pair_of_value, lanes, values),
        (1, false) => rows::<1, false>(sums, pair_of_value, lanes, values),
        (n, _) => {
            for (k, row) in values.chunks_exact_mut(n).enumerate() {
                for (value, &pair) in row.iter_mut().zip(pair_of_value) {
                    *value = sums[pair * lanes + k];
                }
            }
        }
    }
}

/// Rows of `V` values, `STREAM`ed if they begin at a multiple of 16 bytes.
#[inline(always)]
fn rows<const V: usize, const STREAM: bool>(
    sums: &[Complex<f64>],
    pair_of_value: &[usize],
    lanes: usize,
    values: &mut [Complex<f64>],
) {
    let mut columns = [sums; V];
    for v in 0..V {
        columns[v] = &sums[pair_of_value[v] * lanes..][..lanes];
    }
    for (k, row) in values.as_chunks_mut::<V>().0.iter_mut().enumerate() {
        for v in 0..V {
            if STREAM {
                write_past_caches(&mut row[v], columns[v][k]);
            } else {
                row[v] = columns[v][k];
            }
        }
    }
}

/// Writes a value that begins at a multiple of 16 bytes.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn write_past_caches(to: &mut Complex<f64>, value: Complex<f64>) {
    use std::arch::x86_64::{_mm_set_pd, _mm_stream_pd};
    // SAFETY: SSE2 belongs to x86-64; `to` is a whole, exclusively borrowed value of 16 bytes (num_complex lays re and im
    // out in this order), aligned as `scatter` has checked; `finish` orders the write before any reader's.
    unsafe { _mm_stream_pd(std::ptr::from_mut(to).cast(), _mm_set_pd(value.im, value.re)) };
}

/// Writes a value.
#[cfg(not(target_arch = "x86_64"))]
#[inline(always)]
fn write_past_caches(to: &mut Complex<f64>, value: Complex<f64>) {
    *to = value;
}

/// Makes what was written past the caches visible to other threads.
pub(super) fn finish() {
    #[cfg(target_arch = "x86_64")]
    // SAFETY: SSE belongs to x86-64; the fence touches no memory of its own.
    unsafe {
        std::arch::x86_64::_mm_sfence();
    }
}
