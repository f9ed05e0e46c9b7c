//! The WGSL module `brdf_models`: reflectance models of [`gnomon_brdf::Model`] behind one set of functions.

use std::fmt::Write as _;

use gnomon_brdf::Model;

/// A function that every model has: `MODEL_NAME(lobe, ...)`. `reflectance_NAME` chooses among them.
struct Function {
    name: &'static str,
    /// After `lobe: Lobe`, as WGSL declares them.
    parameters: &'static [(&'static str, &'static str)],
    returns: &'static str,
    /// Its value for a `wi` under the surface, where no model is asked.
    under: Option<&'static str>,
}

const FUNCTIONS: [Function; 8] = [
    Function {
        name: "lobe",
        parameters: &[("wo", "vec3f"), ("wi", "vec3f")],
        returns: "vec3f",
        under: Some("vec3f(0.0)"),
    },
    Function {
        name: "sample",
        parameters: &[("wo", "vec3f"), ("u", "vec2f")],
        returns: "vec3f",
        under: None,
    },
    Function {
        name: "pdf",
        parameters: &[("wo", "vec3f"), ("wi", "vec3f")],
        returns: "f32",
        under: Some("0.0"),
    },
    Function {
        name: "light_lobe",
        parameters: &[("wo", "vec3f"), ("light", "LightPatch")],
        returns: "vec3f",
        under: None,
    },
    Function { name: "equivalent_roughness", parameters: &[], returns: "f32", under: None },
    Function {
        name: "albedo",
        parameters: &[("n_dot_v", "f32"), ("ggx", "vec2f")],
        returns: "vec3f",
        under: None,
    },
    Function {
        name: "cached",
        parameters: &[("radiance_f0", "vec3f"), ("radiance_f90", "vec3f"), ("cosines", "f32")],
        returns: "vec3f",
        under: None,
    },
    Function {
        name: "matte_weight",
        parameters: &[("interface_tint", "vec4f"), ("v_dot_h", "f32")],
        returns: "f32",
        under: None,
    },
];

/// The module that imports the files of the models that `is_used` and chooses among their functions; what is left out is compiled nowhere. `has`
/// tells whether a file holds a text; functions that it leaves out are `tables_NAME` of `brdf_tables` for models that are tabulated, which need
/// no file, or `default_NAME` of `brdf_lobe`.
pub(crate) fn source(has: impl Fn(&str, &str) -> bool, is_used: impl Fn(Model) -> bool) -> String {
    // Numbers are those of all models, used or not.
    let used: Vec<(usize, Model, String)> = Model::ALL
        .iter()
        .enumerate()
        .filter(|(_, model)| is_used(**model))
        .map(|(number, model)| (number, *model, model.name().replace('-', "_")))
        .collect();
    let mut text = String::from("#import brdf_lobe\n");
    let tabulated: Vec<String> = used
        .iter()
        .filter(|(_, model, _)| model.is_tabulated())
        .map(|(number, ..)| format!("lobe.model == {number}u"))
        .collect();
    if !tabulated.is_empty() {
        text.push_str("#import brdf_tables\n");
    }
    for (_, _, name) in used.iter().filter(|(_, _, name)| has(&format!("brdf_{name}"), "")) {
        let _ = writeln!(text, "#import brdf_{name}");
    }
    for (number, _, name) in &used {
        let _ = writeln!(text, "const MODEL_{}: u32 = {number}u;", name.to_uppercase());
    }
    let is_tabulated = if tabulated.is_empty() { "false".to_owned() } else { tabulated.join(" || ") };
    let _ = writeln!(text, "fn is_tabulated(lobe: Lobe) -> bool {{\n    return {is_tabulated};\n}}");
    for function in &FUNCTIONS {
        let list = |of: fn(&(&str, &str)) -> String| -> String {
            function.parameters.iter().map(|parameter| format!(", {}", of(parameter))).collect()
        };
        let declared = list(|(name, kind)| format!("{name}: {kind}"));
        let passed = list(|(name, _)| (*name).to_owned());
        let Function { name: what, returns, under, .. } = function;
        let _ = writeln!(text, "fn reflectance_{what}(lobe: Lobe{declared}) -> {returns} {{");
        if let Some(value) = under {
            let _ = writeln!(text, "    if wi.z <= 0.0 {{\n        return {value};\n    }}");
        }
        let _ = writeln!(text, "    switch lobe.model {{");
        for (place, (_, model, name)) in used.iter().enumerate() {
            // WGSL wants a default: the first model.
            let or_default = if place == 0 { ", default" } else { "" };
            let of = if has(&format!("brdf_{name}"), &format!("fn {name}_{what}(")) {
                name
            } else if model.is_tabulated() && has("brdf_tables", &format!("fn tables_{what}(")) {
                "tables"
            } else {
                "default"
            };
            let case = format!("case MODEL_{}{or_default}", name.to_uppercase());
            let _ = writeln!(
                text,
                "        {case}: {{\n            return {of}_{what}(lobe{passed});\n        }}"
            );
        }
        let _ = writeln!(text, "    }}\n}}");
    }
    text
}
