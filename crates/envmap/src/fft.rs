//! Discrete Fourier transform of power-of-two length: rows of an equirect map are periodic, so convolution along them is
//! a product.

use std::f64::consts::TAU;

/// Plan of a transform.
pub(crate) struct Fft {
    /// `cos` and `sin` of `-2 pi k / n`, for `k` below `n / 2`.
    twiddles: Vec<(f64, f64)>,
    /// Place of each element with its index bits reversed.
    reversed: Vec<usize>,
}

impl Fft {
    /// A plan for `length` elements, rounded up to a power of two.
    pub(crate) fn new(length: usize) -> Self {
        let length = length.next_power_of_two();
        let twiddle = |k: usize| {
            let (sin, cos) = (-TAU * k as f64 / length as f64).sin_cos();
            (cos, sin)
        };
        let bits = length.trailing_zeros();
        let reverse = |index: usize| if bits == 0 { 0 } else { index.reverse_bits() >> (usize::BITS - bits) };
        Self {
            twiddles: (0..length / 2).map(twiddle).collect(),
            reversed: (0..length).map(reverse).collect(),
        }
    }

    /// Transforms real and imaginary parts in place, without scaling (Cooley and Tukey 1965). With the two parts exchanged
    /// it is the inverse.
    pub(crate) fn transform(&self, re: &mut [f64], im: &mut [f64]) {
        let length = self.reversed.len();
        let (re, im) = (&mut re[..length], &mut im[..length]);
        for (index, &other) in self.reversed.iter().enumerate() {
            if index < other {
                re.swap(index, other);
                im.swap(index, other);
            }
        }
        let mut half = 1;
        while half < length {
            let stride = length / (2 * half);
            for start in (0..length).step_by(2 * half) {
                let (re_a, re_b) = re[start..start + 2 * half].split_at_mut(half);
                let (im_a, im_b) = im[start..start + 2 * half].split_at_mut(half);
                for k in 0..half {
                    let (cos, sin) = self.twiddles[k * stride];
                    let (x, y) = (re_b[k] * cos - im_b[k] * sin, re_b[k] * sin + im_b[k] * cos);
                    (re_b[k], im_b[k]) = (re_a[k] - x, im_a[k] - y);
                    (re_a[k], im_a[k]) = (re_a[k] + x, im_a[k] + y);
                }
            }
            half *= 2;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_the_sum_that_defines_it() {
        for length in [1, 2, 8, 32] {
            let value = |i: usize| ((i * i % 7) as f64 - 2.0, (i * 3 % 5) as f64);
            let (mut re, mut im): (Vec<f64>, Vec<f64>) = (0..length).map(value).unzip();
            Fft::new(length).transform(&mut re, &mut im);
            for k in 0..length {
                let (mut x, mut y) = (0.0, 0.0);
                for i in 0..length {
                    let (sin, cos) = (-TAU * (i * k) as f64 / length as f64).sin_cos();
                    let (a, b) = value(i);
                    (x, y) = (x + a * cos - b * sin, y + a * sin + b * cos);
                }
                assert!((re[k] - x).abs() < 1e-9 && (im[k] - y).abs() < 1e-9, "length {length}, k {k}");
            }
        }
    }
}
