//! Prints the median time of every fit on a 1024 x 512 map made of a dim gradient, small lamps and a window.

use std::io::Write;

use glam::Vec3;
use gnomon_envmap::Equirect;
use gnomon_image::RgbImage;
use gnomon_lights::bench::time_fits;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let lamps = [(120, 100, 4, 300.0), (500, 60, 6, 150.0), (640, 140, 3, 900.0), (900, 220, 5, 100.0)];
    let map = Equirect::new(RgbImage::from_fn(1024, 512, |x, y| {
        let mut radiance = Vec3::new(0.4, 0.5, 0.7) * (1.2 - y as f32 / 512.0);
        for (lamp_x, lamp_y, radius, strength) in lamps {
            if x.abs_diff(lamp_x).pow(2) + y.abs_diff(lamp_y).pow(2) <= radius * radius {
                radiance += Vec3::new(1.0, 0.8, 0.6) * strength;
            }
        }
        if (280..360).contains(&x) && (160..260).contains(&y) { radiance + 12.0 } else { radiance }
    }));
    let mut out = std::io::stdout().lock();
    for timing in time_fits(&map, 9)? {
        writeln!(out, "{:<12} {:>4} lights {:>8.1} ms", timing.method, timing.lights, timing.median_ms)?;
    }
    Ok(())
}
