//! Least-squares fits of measured points. Points that a fit cannot use (not finite, or not positive where logarithms are
//! taken) are left out.

/// `y = intercept + slope x`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// Change of y for 1 of x.
    pub slope: f64,
    /// y at x = 0.
    pub intercept: f64,
    /// Share of the variance of y that the line explains, 0 to 1; 1 where y does not vary.
    pub r_squared: f64,
}

impl Line {
    /// The line with the least sum of squared differences in y; `None` with fewer than two different x.
    pub fn fit(points: &[(f64, f64)]) -> Option<Self> {
        let points: Vec<_> = points.iter().filter(|(x, y)| x.is_finite() && y.is_finite()).collect();
        let count = points.len() as f64;
        let mean_x = points.iter().map(|point| point.0).sum::<f64>() / count;
        let mean_y = points.iter().map(|point| point.1).sum::<f64>() / count;
        let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
        for (x, y) in points {
            let (x, y) = (x - mean_x, y - mean_y);
            xx += x * x;
            xy += x * y;
            yy += y * y;
        }
        // NaN for no points at all.
        if xx.is_nan() || xx <= 0.0 {
            return None;
        }
        let slope = xy / xx;
        let r_squared = if yy > 0.0 { slope * xy / yy } else { 1.0 };
        Some(Self { slope, intercept: mean_y - slope * mean_x, r_squared })
    }
}

/// `y = factor x^exponent`, a straight line in a plot with two logarithmic axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PowerLaw {
    /// Slope in the logarithmic plot: 1 is linear growth.
    pub exponent: f64,
    /// y at x = 1.
    pub factor: f64,
}

impl PowerLaw {
    /// The law with the least squared differences of log y; `None` with fewer than two different positive x.
    pub fn fit(points: &[(f64, f64)]) -> Option<Self> {
        let logarithms: Vec<_> =
            points.iter().filter(|(x, y)| *x > 0.0 && *y > 0.0).map(|(x, y)| (x.ln(), y.ln())).collect();
        let line = Line::fit(&logarithms)?;
        Some(Self { exponent: line.slope, factor: line.intercept.exp() })
    }

    /// y at `x`.
    pub fn at(&self, x: f64) -> f64 {
        self.factor * x.powf(self.exponent)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_laws_are_found() {
        let line = Line::fit(&[(0.0, 1.0), (1.0, 3.0), (2.0, 5.0), (f64::NAN, 9.0)]).unwrap();
        assert!((line.slope - 2.0).abs() < 1e-12 && (line.intercept - 1.0).abs() < 1e-12);
        assert!((line.r_squared - 1.0).abs() < 1e-12);
        let law = PowerLaw::fit(&[(1.0, 3.0), (4.0, 6.0), (16.0, 12.0), (-1.0, 5.0), (2.0, 0.0)]).unwrap();
        assert!((law.exponent - 0.5).abs() < 1e-12 && (law.at(4.0) - 6.0).abs() < 1e-12);
    }

    #[test]
    fn too_few_points_have_no_law() {
        assert_eq!(Line::fit(&[]), None);
        assert_eq!(Line::fit(&[(1.0, 2.0), (1.0, 3.0)]), None);
        assert_eq!(PowerLaw::fit(&[(1.0, 2.0), (0.0, 3.0), (f64::INFINITY, 1.0)]), None);
    }
}
