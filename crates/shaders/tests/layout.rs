//! `encase` writes the members of shared structs where WGSL reads them.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

use gnomon_shaders::layout::{Struct, described};
use gnomon_shaders::resolve;
use naga::TypeInner;

/// Compares one shared struct with the WGSL struct of the same name; the first difference, if any.
fn difference(module: &naga::Module, shared: &Struct) -> Option<String> {
    let name = shared.name;
    let found = module.types.iter().find(|(_, ty)| ty.name.as_deref() == Some(name));
    let Some((_, ty)) = found else { return Some(format!("no struct {name} in WGSL")) };
    let TypeInner::Struct { members, span } = &ty.inner else { return Some(format!("{name} is no struct")) };
    if u64::from(*span) != shared.size {
        return Some(format!("{name}: {span} bytes in WGSL, {} in Rust", shared.size));
    }
    let in_wgsl: Vec<_> = members
        .iter()
        .map(|member| (member.name.as_deref().unwrap_or_default(), u64::from(member.offset)))
        .collect();
    (in_wgsl != shared.members).then(|| format!("{name}: WGSL has {in_wgsl:?}, Rust {:?}", shared.members))
}

fn differences(source: &str) -> Vec<String> {
    let module = naga::front::wgsl::parse_str(source).unwrap();
    described().iter().filter_map(|shared| difference(&module, shared)).collect()
}

#[test]
fn rust_and_wgsl_structs_agree() {
    assert!(described().len() > 10);
    assert_eq!(differences(&resolve("types", &[]).unwrap()), Vec::<String>::new());
}

#[test]
fn planted_faults_are_found() {
    let source = resolve("types", &[]).unwrap();
    let faults = [
        ("    black_point: f32,\n    white_point: f32,", "    white_point: f32,\n    black_point: f32,"),
        ("@size(12) shape: f32", "shape: f32"),
        ("    size: vec2u,", "    size: vec4u,"),
    ];
    for (right, wrong) in faults {
        let planted = source.replacen(right, wrong, 1);
        assert_ne!(source, planted);
        assert!(!differences(&planted).is_empty(), "{wrong}");
    }
}
