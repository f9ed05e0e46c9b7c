use std::fmt;
use std::io::Read;
use std::path::{Path, PathBuf};

use clap::Args;
use gnomon::envmap::{self, Environment};
use gnomon::options::Given;
use gnomon::picture::{self, LUMINANCE};
use gnomon::scene_files::{self, EnvironmentSource};
use gnomon::studio::{Look, Project, SceneSource, load_surroundings};
use gnomon_terminal::{Terminal, one_line, print, with_causes};
use serde::Serialize;

use crate::error::CliError;
use crate::output;

/// Read scenes and environment maps, and tell of each in one line what was found and what was left out
///
/// Nothing is drawn. Of a folder every file whose name ends like that of a scene or a map is read, in folders in it too. The exit
/// status is 2 if any file cannot be read; all are looked at nevertheless.
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  gnomon inspect robot.glb grace.hdr
  gnomon inspect models/ --json")]
pub struct InspectArgs {
    /// Scenes, environment maps, and folders with such
    #[arg(value_name = "FILE", required = true)]
    files: Vec<PathBuf>,

    /// Print JSON instead of text
    #[arg(long)]
    json: bool,
}

/// What a file holds.
#[derive(Serialize)]
#[serde(untagged)]
enum Found {
    Map(MapFound),
    Scene(Box<SceneFound>),
}

#[derive(Serialize)]
struct MapFound {
    format: &'static str,
    width: u32,
    height: u32,
    projection: &'static str,
    /// Of the map that light is worked out from.
    map_width: u32,
    map_height: u32,
    /// Mean luminance over the sphere.
    mean_luminance: f64,
    /// How it was read.
    details: Vec<String>,
}

#[derive(Serialize)]
struct SceneFound {
    triangles: usize,
    meshes: usize,
    nodes: usize,
    materials: usize,
    textures: usize,
    lights: usize,
    cameras: Vec<String>,
    clips: Vec<String>,
    /// Of the box around all of it, at rest [m].
    extent: Option<[f32; 3]>,
    environment: Option<String>,
}

/// One file, and what is to be told of it.
#[derive(Serialize)]
struct Report {
    file: PathBuf,
    kind: Option<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    found: Option<Found>,
    /// What was left out or assumed, and why.
    left_out: Vec<String>,
    error: Option<String>,
}

/// Runs the command.
///
/// # Errors
/// Files that cannot be read, after all have been looked at; unwritable standard output.
pub fn run(args: &InspectArgs, terminal: Terminal) -> Result<(), CliError> {
    let files: Vec<PathBuf> = args.files.iter().flat_map(|path| listed(path)).collect();
    let bar = terminal.bar("inspecting");
    let mut reports = Vec::new();
    for (index, file) in files.iter().enumerate() {
        bar.tell(&file.to_string_lossy());
        let report = inspected(file);
        if !args.json {
            bar.suspend(|| print(&one_line(&report.to_string())))?;
        }
        reports.push(report);
        bar.set((index + 1) as f32 / files.len() as f32);
    }
    drop(bar);
    if args.json {
        print(&output::json(&reports))?;
    }
    match reports.iter().filter(|report| report.error.is_some()).count() {
        0 => Ok(()),
        unread => Err(CliError::usage(format!("{unread} of {} files cannot be read", reports.len()))),
    }
}

/// A file, or those of a folder that are named like scenes and maps.
fn listed(path: &Path) -> Vec<PathBuf> {
    if !path.is_dir() {
        return vec![path.to_owned()];
    }
    let extensions: Vec<&str> = picture::formats()
        .iter()
        .flat_map(|format| format.extensions)
        .chain(scene_files::formats().iter().flat_map(|format| format.extensions))
        .copied()
        .collect();
    let is_known = |path: &Path| {
        let extension = path.extension().map(|extension| extension.to_string_lossy().to_lowercase());
        extension.is_some_and(|extension| extensions.contains(&extension.as_str()))
    };
    let mut found = Vec::new();
    let entries = std::fs::read_dir(path).into_iter().flatten().flatten();
    // Links to folders may lead in circles.
    let (folders, files): (Vec<_>, Vec<_>) =
        entries.partition(|entry| entry.file_type().is_ok_and(|kind| kind.is_dir()));
    found.extend(files.iter().map(|entry| entry.path()).filter(|path| path.is_file() && is_known(path)));
    found.extend(folders.iter().flat_map(|folder| listed(&folder.path())));
    found.sort();
    found
}

fn inspected(file: &Path) -> Report {
    let mut report =
        Report { file: file.to_owned(), kind: None, found: None, left_out: Vec::new(), error: None };
    let (kind, found) = match is_picture(file) {
        true => ("map", map(file).map(|(found, left_out)| (Found::Map(found), left_out))),
        false => ("scene", scene(file).map(|(found, left_out)| (Found::Scene(Box::new(found)), left_out))),
    };
    report.kind = Some(kind);
    match found {
        Ok((found, left_out)) => (report.found, report.left_out) = (Some(found), left_out),
        // The line begins with the file's name anyway.
        Err(error) => {
            let error = with_causes(&error);
            let name = format!("{}: ", file.display());
            report.error = Some(error.strip_prefix(&name).unwrap_or(&error).to_owned());
        }
    }
    report
}

/// Whether a file begins or is named like a picture.
fn is_picture(file: &Path) -> bool {
    let mut start = Vec::new();
    let read = std::fs::File::open(file).and_then(|file| file.take(4096).read_to_end(&mut start));
    let extension =
        file.extension().map(|extension| extension.to_string_lossy().to_lowercase()).unwrap_or_default();
    let is_named = || picture::formats().iter().any(|format| format.extensions.contains(&extension.as_str()));
    read.is_ok() && picture::format_of(&start).is_some() || is_named()
}

fn map(file: &Path) -> Result<(MapFound, Vec<String>), CliError> {
    let environment = envmap::load(file, envmap::LoadOptions::default())?;
    let left_out = environment.warnings();
    let Environment { map, projection, source_size: (width, height), .. } = &environment;
    let found = MapFound {
        format: environment.description().format,
        width: *width,
        height: *height,
        projection: projection.name(),
        map_width: map.width(),
        map_height: map.height(),
        mean_luminance: map.flux().dot(LUMINANCE.as_dvec3()) / (4.0 * std::f64::consts::PI),
        details: environment.description().details.clone(),
    };
    Ok((found, left_out))
}

fn scene(file: &Path) -> Result<(SceneFound, Vec<String>), CliError> {
    let project =
        Project::open_source(SceneSource::File(file.to_owned()), Look::default(), &Given::default())?;
    let scene = &project.scene;
    let mut left_out = scene.warnings.clone();
    let environment = match &project.look.map {
        None => None,
        Some(source) => {
            left_out.extend(load_surroundings(&project.look)?.1);
            Some(match source {
                EnvironmentSource::File(path) => path.to_string_lossy().into_owned(),
                EnvironmentSource::Builtin(name) => name.clone(),
            })
        }
    };
    let found = SceneFound {
        triangles: scene.triangle_count(),
        meshes: scene.meshes.len(),
        nodes: scene.nodes.len(),
        materials: scene.materials.len(),
        textures: scene.textures.len(),
        lights: scene.lights.len(),
        cameras: scene.cameras.iter().map(|camera| camera.name.clone()).collect(),
        clips: scene.animations.iter().map(|clip| clip.name.clone()).collect(),
        extent: scene.bounds().map(|bounds| (bounds.max - bounds.min).to_array()),
        environment,
    };
    Ok((found, left_out))
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: ", self.file.display())?;
        match (&self.error, &self.found) {
            (Some(error), _) => write!(f, "cannot be read: {error}")?,
            (None, Some(Found::Map(found))) => found.fmt(f)?,
            (None, Some(Found::Scene(found))) => found.fmt(f)?,
            (None, None) => {}
        }
        match self.left_out.as_slice() {
            [] => Ok(()),
            left_out => write!(f, "; but {}", left_out.join("; ")),
        }
    }
}

impl fmt::Display for MapFound {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { format, width, height, projection, map_width, map_height, mean_luminance, details } = self;
        write!(f, "{format} map, {projection}, {width} x {height} texels")?;
        if (map_width, map_height) != (width, height) {
            write!(f, ", lit by {map_width} x {map_height}")?;
        }
        write!(f, ", mean luminance {mean_luminance:.3}")?;
        details.iter().try_for_each(|detail| write!(f, ", {detail}"))
    }
}

impl fmt::Display for SceneFound {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let counted = |count: usize, what: &str| match count {
            1 => format!("1 {what}"),
            count => format!("{count} {what}{}", if what.ends_with('h') { "es" } else { "s" }),
        };
        let named = |names: &[String], what: &str| {
            let known: Vec<&str> = names.iter().map(String::as_str).filter(|name| !name.is_empty()).collect();
            let names_told =
                if known.is_empty() { String::new() } else { format!(" ({})", known.join(", ")) };
            format!("{}{names_told}", counted(names.len(), what))
        };
        write!(f, "scene, {}, {}", counted(self.triangles, "triangle"), counted(self.meshes, "mesh"))?;
        for (count, what) in
            [(self.materials, "material"), (self.textures, "texture"), (self.lights, "light")]
        {
            if count > 0 {
                write!(f, ", {}", counted(count, what))?;
            }
        }
        for (names, what) in [(&self.cameras, "camera"), (&self.clips, "clip")] {
            if !names.is_empty() {
                write!(f, ", {}", named(names, what))?;
            }
        }
        if let Some([x, y, z]) = self.extent {
            write!(f, ", {x:.4} x {y:.4} x {z:.4} m")?;
        }
        match &self.environment {
            Some(environment) => write!(f, ", environment {environment}"),
            None => Ok(()),
        }
    }
}
