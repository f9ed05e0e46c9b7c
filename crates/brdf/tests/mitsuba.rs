//! GGX and Beckmann against values that Mitsuba 3 computed (`reference/microfacet_mitsuba.json`).
#![allow(clippy::unwrap_used, clippy::panic, reason = "tests and their helpers fail by panicking")]

use std::f64::consts::PI;

use gnomon_brdf::{d_beckmann, d_ggx, g1_smith_beckmann, g1_smith_ggx};
use serde_json::Value;

fn data() -> Option<Value> {
    let path = gnomon_testing::data_file("reference/microfacet_mitsuba.json")?;
    Some(serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap())
}

fn entries<'a>(data: &'a Value, kind: &str, table: &str) -> Vec<(f32, &'a Value)> {
    let entries: Vec<_> = data[table]
        .as_array()
        .unwrap()
        .iter()
        .filter(|entry| entry["type"] == kind)
        .map(|entry| (entry["alpha"].as_f64().unwrap() as f32, entry))
        .collect();
    assert!(entries.len() >= 3, "{table} has too few {kind} entries");
    entries
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
}

/// Largest relative difference of `function` from the table; tiny values count against `floor`.
fn worst(data: &Value, kind: &str, table: &str, floor: f64, function: impl Fn(f32, f32) -> f32) -> f64 {
    let mut worst = 0.0f64;
    for (alpha, entry) in entries(data, kind, table) {
        for (theta, expected) in numbers(&entry["theta_deg"]).into_iter().zip(numbers(&entry[table])) {
            let cos_theta = theta.to_radians().cos() as f32;
            let difference = (f64::from(function(cos_theta, alpha)) - expected).abs();
            worst = worst.max(difference / expected.abs().max(floor));
        }
    }
    worst
}

#[test]
fn distribution_and_masking_match() {
    let Some(data) = data() else { return };
    // 2e-4: cos(1 degree) in 32 bits is good to 6e-8, which alpha 0.05 magnifies by 1 / alpha^2 = 400 in D, twice.
    let d = worst(&data, "ggx", "D", 1e-6, d_ggx);
    let g1 = worst(&data, "ggx", "G1", 1e-6, g1_smith_ggx);
    println!("D {d:.1e}, G1 {g1:.1e}");
    assert!(d < 2e-4 && g1 < 2e-5, "D {d}, G1 {g1}");
    let d = worst(&data, "beckmann", "D", 1e-6, d_beckmann);
    let g1 = worst(&data, "beckmann", "G1", 1e-6, g1_smith_beckmann);
    println!("Beckmann: D {d:.1e}, G1 {g1:.1e}");
    // An exponential more in D; the same rational G1 on the other side.
    assert!(d < 1e-3 && g1 < 2e-5, "D {d}, G1 {g1}");
    // Planted fault: roughness in place of alpha.
    assert!(worst(&data, "ggx", "D", 1e-6, |c, alpha| d_ggx(c, alpha.sqrt())) > 0.1);
}

/// Mitsuba's conductor takes the separable `G1 G1`; the glTF model takes the height-correlated G2, tested on its own.
#[test]
fn rough_conductor_matches() {
    let Some(data) = data() else { return };
    let ggx = conductor(&data, "ggx", d_ggx, g1_smith_ggx);
    let beckmann = conductor(&data, "beckmann", d_beckmann, g1_smith_beckmann);
    println!("f cos: GGX {ggx:.1e}, Beckmann {beckmann:.1e}");
    assert!(ggx < 1e-3 && beckmann < 1e-3, "GGX {ggx}, Beckmann {beckmann}");
}

/// Largest relative difference of `f cos`, of the rows above 1e-4.
fn conductor(data: &Value, kind: &str, d: fn(f32, f32) -> f32, g1: fn(f32, f32) -> f32) -> f64 {
    let (mut worst, mut rows) = (0.0f64, 0);
    for (alpha, entry) in entries(data, kind, "roughconductor_F1") {
        for row in entry["rows"].as_array().unwrap() {
            let [theta_i, theta_o, phi, expected] = numbers(row)[..] else { panic!("row {row}") };
            let (theta_i, theta_o, phi) = (theta_i.to_radians(), theta_o.to_radians(), phi * PI / 180.0);
            let h = [
                theta_i.sin() + theta_o.sin() * phi.cos(),
                theta_o.sin() * phi.sin(),
                theta_i.cos() + theta_o.cos(),
            ];
            let n_dot_h = h[2] / h.iter().map(|c| c * c).sum::<f64>().sqrt();
            let (cos_i, cos_o) = (theta_i.cos() as f32, theta_o.cos() as f32);
            let g = g1(cos_i, alpha) * g1(cos_o, alpha);
            let value = f64::from(d(n_dot_h as f32, alpha) * g / (4.0 * cos_i));
            worst = worst.max((value - expected).abs() / expected.max(1e-4));
            rows += 1;
        }
    }
    assert!(rows > 100, "{rows} rows");
    worst
}
