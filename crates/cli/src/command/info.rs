use clap::Args;
use gnomon::renderer::composite::COMPOSITINGS;
use gnomon::renderer::{AdapterSummary, list_adapters};
use gnomon_terminal::print;
use serde_json::json;

use crate::error::CliError;
use crate::output;

/// List graphics adapters with their limits, and every format, fit and built-in
#[derive(Args, Debug)]
pub struct InfoArgs {
    /// Print JSON instead of text
    #[arg(long)]
    json: bool,
}

/// Runs the command.
///
/// # Errors
/// Unwritable standard output.
pub fn run(args: &InfoArgs) -> Result<(), CliError> {
    let adapters = list_adapters();
    let lists = lists();
    if args.json {
        let mut document = json!({ "version": env!("CARGO_PKG_VERSION"), "adapters": adapters });
        for (name, entries) in lists {
            document[name.replace(' ', "_")] = json!(entries);
        }
        return Ok(print(&output::json(&document))?);
    }
    let mut text = format!("gnomon {}\n\nadapters, best first\n", env!("CARGO_PKG_VERSION"));
    if adapters.is_empty() {
        text +=
            "  none: install a Vulkan driver (Debian: libvulkan1 mesa-vulkan-drivers); render needs one\n";
    }
    for adapter in &adapters {
        text += &describe(adapter);
    }
    for (name, entries) in lists {
        text += &format!("\n{name}\n");
        for entry in entries {
            text += &format!("  {entry}\n");
        }
    }
    Ok(print(&text)?)
}

fn describe(adapter: &AdapterSummary) -> String {
    let AdapterSummary { name, backend, kind, driver, usable, max_texture_size, max_shadow_maps } = adapter;
    let unusable = if *usable { "" } else { ", cannot render: something every frame needs is missing" };
    format!(
        "  {name} ({backend}, {kind}{unusable})\n    driver {driver}; textures up to {max_texture_size}, shadow maps up to {max_shadow_maps}\n"
    )
}

/// Everything that goes by a name, by kind.
fn lists() -> Vec<(&'static str, Vec<String>)> {
    let extensions = |extensions: &[&str]| {
        extensions.iter().map(|extension| format!(".{extension}")).collect::<Vec<_>>().join(" ")
    };
    vec![
        (
            "picture formats",
            gnomon::picture::formats()
                .iter()
                .map(|format| {
                    let access = if format.writable { "read and write" } else { "read" };
                    format!("{} ({}): {access}", format.name, extensions(format.extensions))
                })
                .collect(),
        ),
        (
            "scene formats",
            gnomon::scene_files::formats()
                .iter()
                .map(|format| format!("{} ({})", format.name, extensions(format.extensions)))
                .collect(),
        ),
        (
            "environment projections",
            gnomon::envmap::Projection::ALL
                .iter()
                .map(|projection| format!("{}: {}", projection.name(), projection.shape()))
                .collect(),
        ),
        (
            "light fits",
            gnomon::lights::fit::methods()
                .iter()
                .map(|method| format!("{}: {}", method.name, method.summary))
                .collect(),
        ),
        (
            "samplers",
            gnomon::lights::fit::samplers()
                .iter()
                .map(|sampler| format!("{}: {}", sampler.name, sampler.summary))
                .collect(),
        ),
        (
            "shadow techniques",
            gnomon::renderer::shadow::names().map(|(name, summary)| format!("{name}: {summary}")).collect(),
        ),
        (
            "compositing rules",
            COMPOSITINGS.iter().map(|rule| format!("{}: {}", rule.name, rule.summary)).collect(),
        ),
        ("built-in scenes", gnomon::scene::builtin::NAMES.map(str::to_owned).to_vec()),
        ("built-in environments", gnomon::envmap::builtin::names().map(str::to_owned).collect()),
    ]
}
