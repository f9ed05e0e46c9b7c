use std::f32::consts::PI;

use glam::{Vec2, Vec3};
use gnomon_picture::RgbImage;
use rayon::prelude::*;

use crate::Equirect;

/// The room's corners [m]; the viewer stands at the origin, 1.5 m above the floor.
const LOW: Vec3 = Vec3::new(-3.2, -1.5, -2.7);
const HIGH: Vec3 = Vec3::new(3.2, 1.3, 2.7);
/// Samples along each side of a texel that an edge crosses.
const EDGE_SAMPLES: u32 = 3;
/// Windows in the wall at +x: least and largest z and y.
const WINDOWS: [[f32; 4]; 2] = [[-2.0, -0.55, -0.55, 0.85], [0.55, 2.0, -0.55, 0.85]];
/// Width of window bars and frames [m].
const BAR: f32 = 0.035;
/// Mean radiance of the sky in a window, which lights the room.
const DAYLIGHT: Vec3 = Vec3::new(4.6, 5.4, 6.6);
/// Irradiance by light that walls reflect, the same everywhere.
const AMBIENT: Vec3 = Vec3::new(0.62, 0.60, 0.56);

/// A sphere that shines evenly.
struct Lamp {
    centre: Vec3,
    radius: f32,
    radiance: Vec3,
}

const LAMPS: [Lamp; 3] = [
    Lamp { centre: Vec3::new(-1.5, 0.72, 1.1), radius: 0.17, radiance: Vec3::new(26.0, 18.5, 10.5) },
    Lamp { centre: Vec3::new(-1.5, 0.72, -1.1), radius: 0.17, radiance: Vec3::new(26.0, 18.5, 10.5) },
    Lamp { centre: Vec3::new(-2.75, -0.15, -2.2), radius: 0.21, radiance: Vec3::new(17.0, 11.0, 5.5) },
];

/// Furniture: opposite corners of a box, reflectance.
const BOXES: [(Vec3, Vec3, Vec3); 5] = [
    // Sofa: seat and back.
    (Vec3::new(-1.6, -1.5, -2.6), Vec3::new(1.2, -1.05, -1.75), Vec3::new(0.16, 0.24, 0.30)),
    (Vec3::new(-1.6, -1.05, -2.6), Vec3::new(1.2, -0.65, -2.4), Vec3::new(0.18, 0.27, 0.34)),
    // Sideboard.
    (Vec3::new(-3.15, -1.5, -0.9), Vec3::new(-2.75, -0.75, 1.1), Vec3::new(0.34, 0.20, 0.11)),
    // Bookcase.
    (Vec3::new(1.3, -1.5, 2.4), Vec3::new(2.6, 0.6, 2.7), Vec3::new(0.42, 0.30, 0.19)),
    // Stand of the lamp in the corner.
    (Vec3::new(-2.77, -1.5, -2.22), Vec3::new(-2.73, -0.3, -2.18), Vec3::new(0.05, 0.05, 0.05)),
];

/// A furnished room with two windows and three lamps.
pub(super) fn room(width: u32, height: u32) -> Equirect {
    let grid = Equirect::new(RgbImage::filled(width, height, Vec3::ZERO));
    let centres: Vec<Seen> = (0..width * height)
        .into_par_iter()
        .map(|index| see(grid.texel_direction(index % width, index / width)))
        .collect();
    let part = |x: u32, y: u32| centres[y as usize * width as usize + x as usize].part;
    let texel = |index: u32| {
        let (x, y) = (index % width, index / width);
        let around = [
            part((x + 1) % width, y),
            part((x + width - 1) % width, y),
            part(x, y.saturating_sub(1)),
            part(x, (y + 1).min(height - 1)),
        ];
        if around == [part(x, y); 4] {
            return centres[index as usize].radiance;
        }
        let sample = |sample: u32| {
            let at = Vec2::new((sample % EDGE_SAMPLES) as f32, (sample / EDGE_SAMPLES) as f32) + 0.5;
            let at = Vec2::new(x as f32, y as f32) + at / EDGE_SAMPLES as f32;
            see(Equirect::direction_from_uv(at / Vec2::new(width as f32, height as f32))).radiance
        };
        (0..EDGE_SAMPLES * EDGE_SAMPLES).map(sample).sum::<Vec3>() / (EDGE_SAMPLES * EDGE_SAMPLES) as f32
    };
    let texels: Vec<Vec3> = (0..width * height).into_par_iter().map(texel).collect();
    Equirect::new(RgbImage::from_fn(width, height, |x, y| texels[y as usize * width as usize + x as usize]))
}

/// What is seen in a direction: its radiance, and a number for the part of the room that it belongs to.
#[derive(Clone, Copy)]
struct Seen {
    radiance: Vec3,
    part: u32,
}

fn see(direction: Vec3) -> Seen {
    let mut nearest = f32::MAX;
    let mut seen = None;
    for (index, lamp) in (0..).zip(&LAMPS) {
        if let Some(distance) = hit_sphere(direction, lamp).filter(|&distance| distance < nearest) {
            nearest = distance;
            seen = Some(Seen { radiance: lamp.radiance, part: 1000 + index });
        }
    }
    for (index, (low, high, albedo)) in (0..).zip(&BOXES) {
        let Some((distance, normal)) = hit_box(direction, *low, *high) else { continue };
        if distance < nearest {
            nearest = distance;
            let position = direction * distance;
            let grounded = 1.0 - 0.5 * (-(position.y - LOW.y) / 0.15).exp();
            let radiance = *albedo * irradiance(position, normal) * (grounded / PI);
            let face = normal.abs().dot(Vec3::new(1.0, 2.0, 3.0)) as u32;
            seen = Some(Seen { radiance, part: 2000 + 8 * index + face });
        }
    }
    seen.unwrap_or_else(|| wall(direction))
}

fn hit_sphere(direction: Vec3, lamp: &Lamp) -> Option<f32> {
    let along = direction.dot(lamp.centre);
    let square = along * along - lamp.centre.length_squared() + lamp.radius * lamp.radius;
    (along > 0.0 && square > 0.0).then(|| along - square.sqrt())
}

/// Distance to a box from outside, and its normal there.
fn hit_box(direction: Vec3, low: Vec3, high: Vec3) -> Option<(f32, Vec3)> {
    let (a, b) = (low / direction, high / direction);
    let (enter, leave) = (a.min(b), a.max(b));
    let near = enter.max_element();
    (near > 0.0 && near < leave.min_element()).then(|| {
        let axis = if enter.x == near {
            Vec3::X
        } else if enter.y == near {
            Vec3::Y
        } else {
            Vec3::Z
        };
        (near, -axis * direction.dot(axis).signum())
    })
}

fn wall(direction: Vec3) -> Seen {
    let reach = (LOW / direction).max(HIGH / direction);
    let distance = reach.min_element();
    let position = direction * distance;
    let (normal, part, albedo) = if reach.x == distance {
        if direction.x > 0.0 {
            if let Some(seen) = window(position, direction) {
                return seen;
            }
            (Vec3::NEG_X, 10, Vec3::new(0.74, 0.70, 0.63))
        } else {
            let (painting, part) = picture(Vec2::new(position.z, position.y));
            (Vec3::X, 20 + part, painting.unwrap_or(Vec3::new(0.36, 0.47, 0.45)))
        }
    } else if reach.y == distance {
        if direction.y > 0.0 {
            (Vec3::NEG_Y, 40, Vec3::splat(0.82))
        } else {
            let (albedo, part) = floor(Vec2::new(position.x, position.z));
            (Vec3::Y, 100 + part, albedo)
        }
    } else if direction.z > 0.0 {
        let door = position.x > -1.1 && position.x < -0.2 && position.y < 0.55;
        let albedo = if door { Vec3::new(0.78, 0.77, 0.74) } else { Vec3::new(0.74, 0.70, 0.63) };
        (Vec3::NEG_Z, 50 + u32::from(door), albedo)
    } else {
        (Vec3::Z, 60, Vec3::new(0.74, 0.70, 0.63))
    };
    let upright = normal.y == 0.0;
    let skirting = upright && position.y < LOW.y + 0.1;
    let albedo = if skirting { Vec3::splat(0.72) } else { albedo };
    let radiance = albedo * irradiance(position, normal) / PI;
    Seen { radiance, part: 2 * part + u32::from(skirting) }
}

/// What a window shows, or its frame; `None` beside the windows.
fn window(position: Vec3, direction: Vec3) -> Option<Seen> {
    let inside = |[left, right, bottom, top]: &[f32; 4], margin: f32| {
        position.z > left - margin
            && position.z < right + margin
            && position.y > bottom - margin
            && position.y < top + margin
    };
    let (index, window) = (0..).zip(&WINDOWS).find(|(_, window)| inside(window, 2.0 * BAR))?;
    let [left, right, bottom, top] = window;
    let bars =
        [(position.z - 0.5 * (left + right)).abs(), (position.y - (bottom + 0.62 * (top - bottom))).abs()];
    if !inside(window, -0.02) || bars.iter().any(|distance| *distance < 0.5 * BAR) {
        return Some(Seen { radiance: Vec3::splat(0.75) * AMBIENT / PI * 1.6, part: 500 });
    }
    // Far hills under a bright, slightly overcast sky.
    let slope = direction.y / Vec2::new(direction.x, direction.z).length();
    let ridge = |frequency: f32, phase: f32| (frequency * direction.z + phase).sin();
    let hills = 0.05 + 0.03 * ridge(9.0, 0.4) + 0.015 * ridge(23.0, 1.7);
    let seen = if slope < hills {
        Seen { radiance: Vec3::new(0.62, 0.75, 0.42) * (1.0 + 0.8 * (slope - hills)), part: 510 + index }
    } else {
        let height = (slope - hills).clamp(0.0, 1.0);
        let radiance = Vec3::new(6.6, 6.9, 7.2).lerp(Vec3::new(2.6, 4.3, 7.4), height.sqrt());
        Seen { radiance, part: 520 + index }
    };
    Some(seen)
}

/// Pictures on the wall at -x: reflectance of frame, mount and canvas.
fn picture(at: Vec2) -> (Option<Vec3>, u32) {
    let centres = [
        (Vec2::new(-0.85, 0.15), Vec3::new(0.62, 0.26, 0.12)),
        (Vec2::new(0.85, 0.15), Vec3::new(0.15, 0.24, 0.48)),
    ];
    for (index, (centre, canvas)) in (0..).zip(centres) {
        let distance = ((at - centre).abs() - Vec2::new(0.48, 0.36)).max_element();
        let (albedo, part) = match distance {
            d if d > 0.0 => continue,
            d if d > -0.035 => (Vec3::new(0.10, 0.08, 0.06), 1),
            d if d > -0.12 => (Vec3::splat(0.78), 2),
            _ => (canvas * (1.0 + 0.6 * (at.y - centre.y)), 3),
        };
        return (Some(albedo), 4 * index + part);
    }
    (None, 0)
}

/// Reflectance of boards, and of the rug on them.
fn floor(at: Vec2) -> (Vec3, u32) {
    let rug = ((at - Vec2::new(-0.2, 0.2)).abs() - Vec2::new(1.5, 1.1)).max_element();
    if rug < 0.0 {
        return if rug > -0.12 { (Vec3::new(0.55, 0.47, 0.36), 1) } else { (Vec3::new(0.34, 0.09, 0.07), 2) };
    }
    let row = (at.x / 0.16).floor() as i32;
    let board = ((at.y + 0.53 * (row * row % 7) as f32) / 1.3).floor() as i32;
    let hash = (row.wrapping_mul(73) ^ board.wrapping_mul(151)).rem_euclid(17);
    let albedo = Vec3::new(0.42, 0.27, 0.15) * (0.82 + 0.36 * hash as f32 / 16.0);
    (albedo, 3 + hash as u32)
}

/// Irradiance at a point of a surface: windows, lamps, and what the walls reflect, less in corners.
fn irradiance(position: Vec3, normal: Vec3) -> Vec3 {
    let mut sum = Vec3::ZERO;
    for [left, right, bottom, top] in WINDOWS {
        let corner = |y: f32, z: f32| Vec3::new(HIGH.x, y, z) - position;
        let corners = [corner(bottom, left), corner(bottom, right), corner(top, right), corner(top, left)];
        sum += DAYLIGHT * polygon_irradiance(corners, normal);
    }
    for lamp in &LAMPS {
        let to_lamp = lamp.centre - position;
        let square = to_lamp.length_squared().max(lamp.radius * lamp.radius);
        let cosine = (to_lamp.dot(normal) / square.sqrt()).max(0.0);
        sum += lamp.radiance * (PI * lamp.radius * lamp.radius * cosine / square);
    }
    let wall = |low: f32, high: f32, n: f32| if n == 0.0 { low.min(high) } else { f32::MAX };
    let low = position - LOW;
    let high = HIGH - position;
    let corners =
        [wall(low.x, high.x, normal.x), wall(low.y, high.y, normal.y), wall(low.z, high.z, normal.z)];
    let open: f32 = corners.iter().map(|distance| 1.0 - 0.4 * (-distance.max(0.0) / 0.3).exp()).product();
    sum + AMBIENT * open
}

/// Irradiance by a polygon of radiance 1 (Lambert's formula): the sum over its edges of the angle that they subtend times
/// the cosine between the surface's normal and theirs. Parts below the surface count as they would above it, negated.
fn polygon_irradiance(corners: [Vec3; 4], normal: Vec3) -> f32 {
    let corners = corners.map(Vec3::normalize);
    let edge = |index: usize| {
        let (a, b) = (corners[index], corners[(index + 1) % 4]);
        let across = a.cross(b);
        let sine = across.length();
        if sine > 0.0 { across.dot(normal) / sine * sine.atan2(a.dot(b)) } else { 0.0 }
    };
    (0.5 * (0..4).map(edge).sum::<f32>()).abs()
}
