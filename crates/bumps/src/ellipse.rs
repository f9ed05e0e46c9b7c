use glam::{Mat2, Vec2};

/// An ellipse in the tangent plane that directions are projected to: those within are lit, the others are in shadow (Heidrich 2001,
/// section 3.1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ellipse {
    /// Its middle.
    pub center: Vec2,
    /// Unit vector along the first radius.
    pub axis: Vec2,
    /// Half its width and height.
    pub radii: Vec2,
}

/// Least radius: where nothing is lit there still is an ellipse.
const LEAST_RADIUS: f32 = 0.02;
/// Greatest radius: the outline of a large ellipse is a straight edge.
const GREATEST_RADIUS: f32 = 4.0;
/// First and last step by which radii are searched, as powers of two.
const STEPS: [f32; 2] = [0.5, 0.03];

/// The lit directions of a texel: a star around the middle of the disk, by its radius in evenly spread azimuths. Its area is their measure,
/// weighted by the cosine.
pub(crate) struct Star<'a> {
    /// Unit vectors of the azimuths.
    pub azimuths: &'a [Vec2],
    /// In each, the radius within which directions are lit, 0 to 1.
    pub radii: &'a [f32],
}

impl Star<'_> {
    fn around(&self) -> impl Iterator<Item = (Vec2, f32)> {
        self.azimuths.iter().copied().zip(self.radii.iter().copied())
    }

    /// Share of the hemisphere that is lit.
    pub fn area(&self) -> f32 {
        self.radii.iter().map(|r| r * r).sum::<f32>() / self.radii.len() as f32
    }

    /// The ellipse whose mean and covariance are those of the lit directions.
    pub fn covariance_ellipse(&self) -> Ellipse {
        let (mut area, mut mean) = (0.0, Vec2::ZERO);
        let [mut xx, mut xy, mut yy] = [0.0; 3];
        for (d, r) in self.around() {
            let (r2, r3, r4) = (r * r / 2.0, r * r * r / 3.0, r * r * r * r / 4.0);
            area += r2;
            mean += r3 * d;
            (xx, xy, yy) = (xx + r4 * d.x * d.x, xy + r4 * d.x * d.y, yy + r4 * d.y * d.y);
        }
        if area <= 0.0 {
            return Ellipse { center: Vec2::ZERO, axis: Vec2::X, radii: Vec2::splat(LEAST_RADIUS) };
        }
        let center = mean / area;
        let [xx, xy, yy] = [
            xx / area - center.x * center.x,
            xy / area - center.x * center.y,
            yy / area - center.y * center.y,
        ];
        // Eigenvectors of a symmetric matrix lie at half the angle of (xx - yy, 2 xy).
        let half = 0.5 * (2.0 * xy).atan2(xx - yy);
        let axis = Vec2::new(half.cos(), half.sin());
        let (middle, apart) = (0.5 * (xx + yy), (0.25 * (xx - yy) * (xx - yy) + xy * xy).sqrt());
        // A filled ellipse of radius r has the variance r^2 / 4 along it.
        let radius = |variance: f32| (2.0 * variance.max(0.0).sqrt()).clamp(LEAST_RADIUS, GREATEST_RADIUS);
        Ellipse { center, axis, radii: Vec2::new(radius(middle + apart), radius(middle - apart)) }
    }

    /// The paper's criterion: lit directions inside less shadowed ones inside, as shares of the hemisphere.
    pub fn criterion(&self, ellipse: &Ellipse) -> f32 {
        let form = ellipse.form();
        let (to_center, constant) = (form * ellipse.center, ellipse.center.dot(form * ellipse.center) - 1.0);
        let mut sum = 0.0;
        for (d, r) in self.around() {
            // Where the ray from the middle of the disk enters and leaves the ellipse.
            let (a, b) = (d.dot(form * d), d.dot(to_center));
            let discriminant = b * b - a * constant;
            if discriminant <= 0.0 {
                continue;
            }
            let root = discriminant.sqrt();
            let [enters, leaves] = [(b - root) / a, (b + root) / a].map(|t| t.clamp(0.0, 1.0));
            let between = |[from, to]: [f32; 2]| to * to - from * from;
            sum += 2.0 * between([enters.min(r), leaves.min(r)]) - between([enters, leaves]);
        }
        sum / self.radii.len() as f32
    }

    /// The ellipse of the covariance with radii that hold as many lit and as few shadowed directions as can be.
    pub fn fitted(&self) -> Ellipse {
        let mut best = self.covariance_ellipse();
        let mut highest = self.criterion(&best);
        let mut step = STEPS[0];
        while step > STEPS[1] {
            let (larger, smaller) = (step.exp2(), (-step).exp2());
            let changes = [
                (larger, 1.0),
                (smaller, 1.0),
                (1.0, larger),
                (1.0, smaller),
                (larger, larger),
                (smaller, smaller),
            ];
            let tried = changes.map(|(x, y)| {
                let radii = (best.radii * Vec2::new(x, y))
                    .clamp(Vec2::splat(LEAST_RADIUS), Vec2::splat(GREATEST_RADIUS));
                Ellipse { radii, ..best }
            });
            let scored = tried.map(|ellipse| (self.criterion(&ellipse), ellipse));
            let found = scored.into_iter().fold((highest, best), |a, b| if b.0 > a.0 { b } else { a });
            if found.0 > highest {
                (highest, best) = found;
            } else {
                step *= 0.5;
            }
        }
        best
    }
}

impl Ellipse {
    /// Its quadratic form Q: a point p is inside where (p - center) . Q (p - center) <= 1.
    pub fn form(&self) -> Mat2 {
        self.of_squares(Vec2::ONE / (self.radii * self.radii))
    }

    /// The inverse of [`Ellipse::form`], which filters well: x x, x y and y y.
    pub fn shape(&self) -> [f32; 3] {
        let shape = self.of_squares(self.radii * self.radii);
        [shape.x_axis.x, shape.x_axis.y, shape.y_axis.y]
    }

    fn of_squares(&self, along: Vec2) -> Mat2 {
        let turn = Mat2::from_cols(self.axis, self.axis.perp());
        turn * Mat2::from_diagonal(along) * turn.transpose()
    }

    /// Whether it holds a direction's projection to the tangent plane.
    pub fn holds(&self, direction: Vec2) -> bool {
        let from_center = direction - self.center;
        from_center.dot(self.form() * from_center) <= 1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn azimuths(count: usize) -> Vec<Vec2> {
        (0..count).map(|i| Vec2::from_angle(std::f32::consts::TAU * i as f32 / count as f32)).collect()
    }

    #[test]
    fn an_open_and_a_closed_hemisphere() {
        let azimuths = azimuths(32);
        let open = Star { azimuths: &azimuths, radii: &[1.0; 32] };
        let ellipse = open.covariance_ellipse();
        assert!(ellipse.center.length() < 1e-6 && (ellipse.radii - 1.0).length() < 1e-4, "{ellipse:?}");
        assert!((open.criterion(&open.fitted()) - 1.0).abs() < 1e-5);
        let closed = Star { azimuths: &azimuths, radii: &[0.0; 32] };
        assert!(!closed.fitted().holds(Vec2::new(0.1, 0.0)) && closed.fitted().form().is_finite());
    }

    #[test]
    fn an_ellipse_is_found_again() {
        let azimuths = azimuths(64);
        let true_one = Ellipse {
            center: Vec2::new(0.1, -0.05),
            axis: Vec2::from_angle(0.4),
            radii: Vec2::new(0.7, 0.3),
        };
        let edge = |d: Vec2| {
            let steps = (0..2000).map(|i| i as f32 / 2000.0);
            steps.take_while(|&t| true_one.holds(t * d)).last().unwrap_or(0.0)
        };
        let radii: Vec<f32> = azimuths.iter().map(|&d| edge(d)).collect();
        let star = Star { azimuths: &azimuths, radii: &radii };
        let found = star.fitted();
        assert!((found.center - true_one.center).length() < 0.01, "{found:?}");
        assert!((found.radii - true_one.radii).length() < 0.02, "{found:?}");
        assert!(star.area() - star.criterion(&found) < 0.02 * star.area());
        let [xx, xy, yy] = found.shape();
        let identity = Mat2::from_cols(Vec2::new(xx, xy), Vec2::new(xy, yy)) * found.form();
        assert!((identity - Mat2::IDENTITY).to_cols_array().iter().all(|v| v.abs() < 1e-3));
    }
}
