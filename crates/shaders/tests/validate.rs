//! Every shader, with every choice for its slots, parses and validates without a GPU.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

use gnomon_shaders::{ENTRIES, modules, resolve};
use naga::valid::{Capabilities, ValidationFlags, Validator};

fn validate(source: &str) -> Result<naga::Module, String> {
    let module = naga::front::wgsl::parse_str(source).map_err(|error| error.emit_to_string(source))?;
    Validator::new(ValidationFlags::all(), Capabilities::all())
        .validate(&module)
        .map_err(|error| error.emit_to_string(source))?;
    Ok(module)
}

/// Models as most scenes have them, with nothing on their bases.
const FEW_MODELS: (&str, &str) = ("brdf_models", "metallic-roughness lambert");

/// All ways to fill the slots of one entry.
fn combinations(slots: &[(&'static str, &'static [&'static str])]) -> Vec<Vec<(&'static str, &'static str)>> {
    slots.iter().fold(vec![Vec::new()], |sets, (slot, choices)| {
        sets.iter()
            .flat_map(|set| {
                choices.iter().map(move |choice| {
                    let mut set = set.clone();
                    set.push((*slot, *choice));
                    set
                })
            })
            .collect()
    })
}

#[test]
fn every_entry_validates_with_every_choice() {
    let mut entry_points = 0;
    for entry in ENTRIES {
        let few = combinations(entry.slots).into_iter().map(|slots| [slots, vec![FEW_MODELS]].concat());
        for slots in combinations(entry.slots).into_iter().chain(few) {
            let source = resolve(entry.module, &slots).unwrap();
            let module =
                validate(&source).unwrap_or_else(|error| panic!("{} {slots:?}:\n{error}", entry.module));
            assert!(!module.entry_points.is_empty(), "{} has no entry point", entry.module);
            entry_points += module.entry_points.len();
        }
    }
    assert!(entry_points > 0);
}

#[test]
fn no_module_is_out_of_reach() {
    let mut reached = String::new();
    for entry in ENTRIES {
        for slots in combinations(entry.slots) {
            let few = [slots.as_slice(), &[FEW_MODELS]].concat();
            reached.push_str(&resolve(entry.module, &few).unwrap());
            reached.push_str(&resolve(entry.module, &slots).unwrap());
        }
    }
    for module in modules() {
        let filled = [
            ("shadow", "shadow_none"),
            ("bumps", "bumps_none"),
            ("composite", "composite_additive"),
            ("reflections", "reflections_off"),
        ];
        let own = resolve(module, &filled).unwrap();
        let last = own.lines().rev().find(|line| {
            line.starts_with("fn ")
                || line.starts_with("struct ")
                || line.starts_with("@group")
                || line.starts_with("const ")
        });
        if let Some(line) = last {
            assert!(reached.contains(line), "module {module} is imported by no entry");
        }
    }
}

#[test]
fn a_planted_type_error_is_found() {
    let source = resolve("tonemap", &[])
        .unwrap()
        .replace("let desaturation = 0.15;", "let desaturation = vec2f(0.15);");
    assert!(validate(&source).is_err());
}
