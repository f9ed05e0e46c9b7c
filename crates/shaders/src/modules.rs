use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::LazyLock;

/// A shader could not be put together. Always a fault of the project, never of the user's input.
#[derive(Debug, thiserror::Error)]
pub enum ShaderError {
    /// An import names no module.
    #[error("shader module `{module}` (imported by `{importer}`) does not exist")]
    UnknownModule {
        /// The missing module.
        module: String,
        /// Who asked for it.
        importer: String,
    },
    /// An import names a slot that the caller has not filled.
    #[error("shader `{importer}` needs a module in slot `{slot}`")]
    EmptySlot {
        /// The empty slot.
        slot: String,
        /// Who asked for it.
        importer: String,
    },
}

/// A slot's name and the module that fills it, as in `("shadow", "shadow_hard")`.
pub type Slot<'a> = (&'a str, &'a str);

/// A module with entry points and the choices for its slots: what the tests validate.
pub struct Entry {
    /// Module name.
    pub module: &'static str,
    /// Slots and every module that may fill them.
    pub slots: &'static [(&'static str, &'static [&'static str])],
}

/// Every file of `wgsl/`: its name and text.
const FILES: &[(&str, &str)] = include!(concat!(env!("OUT_DIR"), "/modules.rs"));

/// Name and text of every module: the files, and what is made of lists in Rust.
static MODULES: LazyLock<BTreeMap<&str, Cow<'_, str>>> = LazyLock::new(|| {
    let mut modules: BTreeMap<_, _> = FILES.iter().map(|(name, text)| (*name, Cow::from(*text))).collect();
    let has = |module: &str, text: &str| modules.get(module).is_some_and(|m| m.contains(text));
    let models = crate::models::source(has, |_| true);
    modules.insert(MODELS, models.into());
    modules.insert("types", crate::layout::MODULE.as_str().into());
    modules
});

/// The module of reflectance models, and the slot that names those that it is to have.
const MODELS: &str = "brdf_models";

/// The module of what lies on the base of surfaces, and the name among those of models that asks for it.
const FINISH: &str = "finish";

/// Every module that the renderer makes a pipeline of.
pub const ENTRIES: &[Entry] = &[
    Entry { module: "basis", slots: &[] },
    Entry {
        module: "compose",
        slots: &[("composite", &["composite_additive", "composite_subtractive", "composite_ratio"])],
    },
    Entry { module: "debug_view", slots: &[] },
    Entry { module: "downsample", slots: &[] },
    Entry { module: "edge_refit", slots: &[] },
    Entry { module: "even_sums", slots: &[] },
    Entry { module: "gbuffer", slots: &[] },
    Entry { module: "gbuffer_layers", slots: &[] },
    Entry { module: "gloss", slots: &[("reflections", &["reflections_off", "reflections_scene"])] },
    Entry { module: "layers", slots: &[] },
    Entry { module: "light", slots: &[("shadow", SHADOWS), ("bumps", &["bumps_none"])] },
    Entry { module: "light", slots: &[("shadow", &["shadow_buffered", "shadow_pcss"]), ("bumps", BUMPS)] },
    Entry { module: "min_max", slots: &[] },
    Entry { module: "moments", slots: &[] },
    Entry { module: "present", slots: &[] },
    Entry { module: "radiance_cache", slots: &[] },
    Entry { module: "ray_refit", slots: &[] },
    Entry { module: "relief", slots: &[] },
    Entry { module: "resolve", slots: &[] },
    Entry { module: "seen", slots: &[] },
    Entry { module: "shading_points", slots: &[] },
    Entry { module: "shadow_map", slots: &[] },
    Entry { module: "shadow_map_masked", slots: &[] },
    Entry { module: "shadow_volumes", slots: &[] },
    Entry { module: "silhouettes", slots: &[] },
    Entry { module: "stencil_depth", slots: &[] },
    Entry { module: "stencil_visibility", slots: &[] },
    Entry { module: "summed_area", slots: &[] },
    Entry { module: "transform", slots: &[] },
    Entry { module: "visibility", slots: &[("shadow", SHADOWS), ("bumps", BUMPS)] },
    Entry { module: "visibility", slots: &[("shadow", BUFFERED_SHADOWS), ("bumps", BUMPS)] },
];

/// What bumps do to light.
const BUMPS: &[&str] = &["bumps_none", "bumps_ellipses", "bumps_horizons"];

/// Shadow techniques whose function only fills a buffer: beside the sums of light there is no room for what they read.
const BUFFERED_SHADOWS: &[&str] = &["shadow_wedges"];

/// Every shadow technique with a function of its own.
const SHADOWS: &[&str] = &[
    "shadow_none",
    "shadow_hard",
    "shadow_hard_linear",
    "shadow_pcf",
    "shadow_pcss",
    "shadow_moments",
    "shadow_backprojection",
    "shadow_bitmask",
    "shadow_rays",
    "shadow_convolution",
    "shadow_convolution_anisotropic",
    "shadow_convolution_sat",
];

/// Names of all modules.
pub fn modules() -> impl Iterator<Item = &'static str> {
    MODULES.keys().copied()
}

/// The WGSL of `module` with everything it imports before it, each module once.
///
/// A line `#import name` brings in a module, `#import slot:name` the module that `slots` puts there. The slot `brdf_models` holds names of
/// reflectance models, separated by blanks: shaders then know no others, and what lies on them only where `finish` is among the names. Without
/// it they know all.
pub fn resolve(module: &str, slots: &[Slot<'_>]) -> Result<String, ShaderError> {
    let mut resolver = Resolver { slots, done: BTreeSet::new(), output: String::new() };
    resolver.add(module, "the renderer")?;
    Ok(resolver.output)
}

/// The module of these models.
fn models_named(names: &str) -> String {
    let has = |module: &str, text: &str| MODULES.get(module).is_some_and(|m| m.contains(text));
    crate::models::source(has, |model| names.split(' ').any(|name| name == model.name()))
}

struct Resolver<'a> {
    slots: &'a [Slot<'a>],
    done: BTreeSet<String>,
    output: String,
}

impl Resolver<'_> {
    fn add(&mut self, module: &str, importer: &str) -> Result<(), ShaderError> {
        if !self.done.insert(module.to_owned()) {
            return Ok(());
        }
        let models = self.slots.iter().find(|(slot, _)| *slot == MODELS).map(|(_, names)| names);
        let has_finish = models.is_none_or(|names| names.split(' ').any(|name| name == FINISH));
        let source = match models {
            Some(names) if module == MODELS => Cow::from(models_named(names)),
            _ if module == FINISH => {
                Cow::from(if has_finish { "#import finish_some" } else { "#import finish_none" })
            }
            _ => MODULES.get(module).cloned().ok_or_else(|| ShaderError::UnknownModule {
                module: module.to_owned(),
                importer: importer.to_owned(),
            })?,
        };
        let mut body = String::new();
        for line in source.lines() {
            match line.strip_prefix("#import ").map(str::trim) {
                Some(import) => match import.strip_prefix("slot:") {
                    Some(slot) => {
                        let filled = self.slots.iter().find(|(name, _)| *name == slot);
                        let (_, module_in_slot) = filled.ok_or_else(|| ShaderError::EmptySlot {
                            slot: slot.to_owned(),
                            importer: module.to_owned(),
                        })?;
                        self.add(module_in_slot, module)?;
                    }
                    None => self.add(import, module)?,
                },
                None => {
                    body.push_str(line);
                    body.push('\n');
                }
            }
        }
        self.output.push_str(&body);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_module_imported_twice_appears_once() {
        let source = resolve("light", &[("shadow", "shadow_hard"), ("bumps", "bumps_none")]).unwrap();
        assert_eq!(source.matches("struct View {").count(), 1);
        assert!(!source.contains("#import"));
    }

    #[test]
    fn shaders_know_the_models_that_are_asked_for() {
        let slots = [("composite", "composite_ratio")];
        let all = resolve("compose", &slots).unwrap();
        assert!(all.contains("fn tables_lobe(") && all.contains("fn phong_lobe("));
        let few = [slots[0], (MODELS, "metallic-roughness lambert")];
        let few = resolve("compose", &few).unwrap();
        assert!(few.contains("fn metallic_roughness_lobe(") && !few.contains("fn phong_lobe("));
        assert!(!few.contains("fn tables_lobe("));
    }

    #[test]
    fn an_empty_slot_and_an_unknown_module_are_named() {
        let error = resolve("light", &[]).unwrap_err();
        assert!(error.to_string().contains("slot `shadow`"));
        let error = resolve("light", &[("shadow", "shadow_moon")]).unwrap_err();
        assert!(error.to_string().contains("`shadow_moon`"));
    }
}
