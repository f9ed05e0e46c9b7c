use glam::{Vec2, Vec3};
use gnomon_picture::RgbImage;
use rayon::prelude::*;

use crate::Equirect;

/// Samples along each side of a texel: edges of the panels are straight lines.
const SAMPLES: u32 = 4;

/// A panel that shines evenly: towards its middle, half its width to the side and half its height, at distance 1.
struct Panel {
    towards: Vec3,
    half: Vec2,
    radiance: Vec3,
}

const PANELS: [Panel; 3] = [
    // The key light, to the right and above.
    Panel {
        towards: Vec3::new(0.75, 0.62, 0.35),
        half: Vec2::new(0.42, 0.42),
        radiance: Vec3::new(5.2, 4.9, 4.5),
    },
    // A fill to the left, larger and fainter.
    Panel {
        towards: Vec3::new(-0.85, 0.25, 0.3),
        half: Vec2::new(0.5, 0.7),
        radiance: Vec3::new(0.85, 0.95, 1.1),
    },
    // A strip behind, for rims.
    Panel {
        towards: Vec3::new(-0.35, 0.5, -0.8),
        half: Vec2::new(0.1, 0.6),
        radiance: Vec3::new(7.0, 7.2, 7.6),
    },
];
/// Walls at the horizon and overhead, and the floor.
const HORIZON: Vec3 = Vec3::new(0.30, 0.30, 0.31);
const CEILING: Vec3 = Vec3::new(0.10, 0.10, 0.11);
const FLOOR: Vec3 = Vec3::new(0.22, 0.21, 0.20);

/// A photographer's studio: three panels in a grey room.
pub(super) fn studio(width: u32, height: u32) -> Equirect {
    let size = Vec2::new(width as f32, height as f32);
    let texel = |index: u32| {
        let sample = |sample: u32| {
            let at = Vec2::new((sample % SAMPLES) as f32, (sample / SAMPLES) as f32) + 0.5;
            let at = Vec2::new((index % width) as f32, (index / width) as f32) + at / SAMPLES as f32;
            seen(Equirect::direction_from_uv(at / size))
        };
        (0..SAMPLES * SAMPLES).map(sample).sum::<Vec3>() / (SAMPLES * SAMPLES) as f32
    };
    let texels: Vec<Vec3> = (0..width * height).into_par_iter().map(texel).collect();
    Equirect::new(RgbImage::from_fn(width, height, |x, y| texels[(y * width + x) as usize]))
}

fn seen(direction: Vec3) -> Vec3 {
    let panel = PANELS.iter().find(|panel| panel.covers(direction));
    panel.map_or_else(|| wall(direction), |panel| panel.radiance)
}

fn wall(direction: Vec3) -> Vec3 {
    match direction.y {
        up if up >= 0.0 => HORIZON.lerp(CEILING, up),
        // The floor and the walls meet in a curve.
        down => HORIZON.lerp(FLOOR, (-4.0 * down).min(1.0)),
    }
}

impl Panel {
    fn covers(&self, direction: Vec3) -> bool {
        let forward = self.towards.normalize();
        let right = forward.cross(Vec3::Y).normalize();
        let up = right.cross(forward);
        let depth = direction.dot(forward);
        let at = Vec2::new(direction.dot(right), direction.dot(up)) / depth;
        depth > 0.0 && at.abs().cmple(self.half).all()
    }
}
