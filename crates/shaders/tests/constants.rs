//! Constants that crates without shaders share with them: the same number in both texts.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by it")]

/// Name, shaders and Rust files that declare it.
const SHARED: &[(&str, &[&str], &str)] = &[
    ("MIN_N_DOT_V", &["brdf_lobe"], "brdf/src/ggx.rs"),
    ("COAT_F0", &["brdf_finish"], "brdf/src/finish.rs"),
    ("MIN_SHEEN_ROUGHNESS", &["brdf_sheen"], "brdf/src/sheen.rs"),
    ("DISK_CORNERS", &["form_factor"], "lights/src/form_factor.rs"),
    ("LEAST_COSINE", &["height_slopes"], "scene/src/height.rs"),
    ("LOOKUP_VARIANCE", &["series"], "renderer/src/light_frame.rs"),
    ("GOLDEN_ANGLE", &["sample_pattern"], "shaders/src/twin/sample_pattern.rs"),
    ("END_CLEARANCE", &["shadow_rays", "shadow_wedges"], "reference/src/traced_scene.rs"),
];

/// The value of a constant in a text: a sum of numbers or quotients.
fn value(text: &str, name: &str) -> Option<f32> {
    let line = text.lines().find(|line| line.contains(&format!("const {name}:")))?;
    let number = |text: &str| text.trim().trim_end_matches('u').replace('_', "").parse::<f32>().ok();
    let (_, sum) = line.trim().strip_suffix(';')?.split_once('=')?;
    let quotient = |part: &str| match part.split_once('/') {
        Some((over, under)) => Some(number(over)? / number(under)?),
        None => number(part),
    };
    sum.split('+').map(quotient).sum()
}

#[test]
fn shaders_and_rust_have_the_same_constants() {
    let crates = format!("{}/..", env!("CARGO_MANIFEST_DIR"));
    let read = |path: String, name: &str| {
        let text = std::fs::read_to_string(&path).unwrap();
        value(&text, name).unwrap_or_else(|| panic!("{path} declares no {name}"))
    };
    for (name, shaders, rust) in SHARED {
        let in_rust = read(format!("{crates}/{rust}"), name);
        for shader in *shaders {
            let in_shader = read(format!("{crates}/shaders/wgsl/{shader}.wgsl"), name);
            let error = (in_shader - in_rust).abs();
            assert!(
                error <= f32::EPSILON * in_rust.abs(),
                "{name} is {in_shader} in {shader} and {in_rust} in {rust}"
            );
        }
    }
}

#[test]
fn another_value_is_seen() {
    let text = "    const A: f32 = 1.0 / 4.0 + 1.0 / 6.0;\nconst B: u32 = 16u;\n";
    assert_eq!(
        (value(text, "A"), value(text, "B"), value(text, "C")),
        (Some(0.25 + 1.0 / 6.0), Some(16.0), None)
    );
}
