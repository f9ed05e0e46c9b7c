use std::path::PathBuf;

use clap::Args;

use crate::error::CliError;

/// Open a window on a scene: look around, change everything, compare with the reference
///
/// Models, scene files and environments can be dropped on the window. Press ? in it for keys and mouse.
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  gnomon view
  gnomon view robot.glb --env grace.hdr
  gnomon view scene.toml --target-fps 30")]
pub struct ViewArgs {
    /// A model or scene file, or a built-in scene [default: a built-in scene]
    #[arg(value_name = "SCENE")]
    scene: Option<String>,

    /// The environment: a file, or a built-in one [default: the scene's own, or a built-in one]
    #[arg(long, value_name = "ENV")]
    env: Option<String>,

    /// Part of the name of the adapter to use (see gnomon info) [default: the fastest]
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,

    /// Let the number of lights, the size of their maps and shadow sampling follow this many frames a second
    #[arg(long, value_name = "FPS", value_parser = frames_per_second)]
    target_fps: Option<f64>,

    /// Width and height of the window [default: 1280x800]
    #[arg(long, value_name = "WxH", value_parser = size)]
    size: Option<[f32; 2]>,

    /// Do what a file says in place of a user, one action a line, as tests do (see the documentation of the crate gnomon-viewer)
    #[arg(long, value_name = "FILE")]
    script: Option<PathBuf>,
}

fn frames_per_second(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(fps) if fps > 0.0 && fps <= 1000.0 => Ok(fps),
        _ => Err("give a number above 0 and at most 1000".to_owned()),
    }
}

fn size(text: &str) -> Result<[f32; 2], String> {
    let wrong = || "give width and height as in 1280x800, 160 to 16384 each".to_owned();
    let side = |text: &str| text.parse::<u16>().ok().filter(|side| (160..=16384).contains(side));
    let (width, height) = text.split_once('x').ok_or_else(wrong)?;
    match (side(width), side(height)) {
        (Some(width), Some(height)) => Ok([width, height].map(f32::from)),
        _ => Err(wrong()),
    }
}

/// Runs the command.
///
/// # Errors
/// No display, no adapter that can draw to it, a script that fails. All else is told in the window.
pub fn run(args: &ViewArgs) -> Result<(), CliError> {
    Ok(gnomon_viewer::run(gnomon_viewer::Options {
        scene: args.scene.clone(),
        environment: args.env.clone(),
        adapter: args.adapter.clone(),
        target_fps: args.target_fps,
        script: args.script.clone(),
        size: args.size,
    })?)
}
