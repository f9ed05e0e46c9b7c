//! Quadrature, random numbers and the chi-square law for the tests of this crate.
#![allow(dead_code, reason = "each test file uses a part")]

use glam::Vec3;

/// PCG32 (O'Neill 2014): a generator of the tests' own, so that results do not change with a dependency.
pub struct Pcg(pub u64);

impl Pcg {
    pub fn next_f32(&mut self) -> f32 {
        let old = self.0;
        self.0 = old.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        let xorshifted = (((old >> 18) ^ old) >> 27) as u32;
        (xorshifted.rotate_right((old >> 59) as u32) >> 8) as f32 / (1u32 << 24) as f32
    }
}

pub fn direction(theta: f64, phi: f64) -> Vec3 {
    Vec3::new((theta.sin() * phi.cos()) as f32, (theta.sin() * phi.sin()) as f32, theta.cos() as f32)
}

/// Midpoint rule over the patch `theta x phi`, in solid angle.
pub fn integrate(theta: [f64; 2], phi: [f64; 2], steps: [usize; 2], f: impl Fn(Vec3) -> f64) -> f64 {
    let (dt, dp) = ((theta[1] - theta[0]) / steps[0] as f64, (phi[1] - phi[0]) / steps[1] as f64);
    let mut sum = 0.0;
    for i in 0..steps[0] {
        let t = theta[0] + (i as f64 + 0.5) * dt;
        for j in 0..steps[1] {
            sum += f(direction(t, phi[0] + (j as f64 + 0.5) * dp)) * t.sin();
        }
    }
    sum * dt * dp
}

/// Upper-tail probability of a chi-square statistic, by Wilson and Hilferty's cube-root normal approximation (1931): good
/// to a few per cent of itself for more than 30 degrees of freedom, far finer than the thresholds it is held against.
pub fn chi_square_p(statistic: f64, degrees: f64) -> f64 {
    let v = 2.0 / (9.0 * degrees);
    let z = ((statistic / degrees).cbrt() - (1.0 - v)) / v.sqrt();
    0.5 * erfc(z / std::f64::consts::SQRT_2)
}

/// Abramowitz and Stegun 7.1.26, absolute error 1.5e-7.
fn erfc(x: f64) -> f64 {
    let t = 1.0 / (1.0 + 0.3275911 * x.abs());
    let poly =
        t * (0.254829592 + t * (-0.284496736 + t * (1.421413741 + t * (-1.453152027 + t * 1.061405429))));
    let tail = poly * (-x * x).exp();
    if x >= 0.0 { tail } else { 2.0 - tail }
}
