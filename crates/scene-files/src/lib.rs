//! Scene files: [`load`] reads one of any format that [`formats`] lists, [`load_from`] and [`load_bytes`] one that is no file, [`read_camera`] a
//! camera, [`read_sections`] what a scene file says of how it is drawn. One file a format; a new one is registered in `FORMATS`.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use gnomon_scene::{Ground, Scene};

use crate::error::Fault;

mod axes;
mod camera;
mod color;
mod error;
mod geometry;
mod gltf;
mod heights;
mod ies;
mod mtl;
mod obj;
mod ply;
mod polygon;
mod resolver;
mod stl;
mod text;
mod texture;
mod toml;

pub use axes::{Axes, UNITS, UpAxis};
pub use camera::read_camera;
pub use error::SceneFileError;
pub use resolver::{FileResolver, ReadError, Resolver, plain};
pub use toml::read_sections;

/// A scene format that [`load`] reads.
#[derive(Debug)]
pub struct Format {
    /// Its name, as people write it.
    pub name: &'static str,
    /// File name extensions, lower case.
    pub extensions: &'static [&'static str],
    /// The ground under a scene of this format that brings none ([`Scene::brings_ground`]), unless the user says otherwise.
    pub default_ground: Ground,
    /// Whether its files say what their axes and unit are.
    pub has_axes: bool,
    /// Whether the content starts the way only this format does.
    recognise: fn(&[u8]) -> bool,
    read: fn(&Source, &mut Budget) -> Result<LoadedScene, Fault>,
}

static FORMATS: [Format; 5] = [
    Format {
        name: "glTF 2.0",
        extensions: &["glb", "gltf"],
        default_ground: Ground::Fade,
        has_axes: true,
        recognise: gltf::recognise,
        read: gltf::read,
    },
    Format {
        name: "OBJ",
        extensions: &["obj"],
        default_ground: Ground::Fade,
        has_axes: false,
        recognise: |_| false,
        read: obj::read,
    },
    Format {
        name: "PLY",
        extensions: &["ply"],
        default_ground: Ground::Fade,
        has_axes: false,
        recognise: ply::recognise,
        read: ply::read,
    },
    Format {
        name: "STL",
        extensions: &["stl"],
        default_ground: Ground::Fade,
        has_axes: false,
        recognise: |_| false,
        read: stl::read,
    },
    Format {
        name: "Gnomon scene",
        extensions: &["toml"],
        default_ground: Ground::None,
        has_axes: false,
        recognise: |_| false,
        read: toml::read,
    },
];

/// Every scene format that [`load`] reads.
pub fn formats() -> &'static [Format] {
    &FORMATS
}

/// What the caller decides about loading.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadOptions {
    /// Bytes that files, geometry and textures of one scene may take together; beyond it loading ends in
    /// [`SceneFileError::TooLarge`].
    pub memory_limit: usize,
    /// Width over height of the picture to be made, for glTF cameras: what they show is all in it.
    pub aspect: f32,
    /// The material variant to be shown of glTF files that have it, by its name; it goes before what a scene file says.
    pub variant: Option<String>,
    /// Axes and unit of files that do not say: of OBJ, PLY and STL files, and of those that a scene file places. They go before what a scene
    /// file says of all its models, but not before what it says of one.
    pub axes: Axes,
}

impl Default for LoadOptions {
    fn default() -> Self {
        Self { memory_limit: 1 << 30, aspect: 4.0 / 3.0, variant: None, axes: Axes::default() }
    }
}

/// Where the environment comes from.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum EnvironmentSource {
    /// A picture file.
    File(PathBuf),
    /// One made by code, by its name (the envmap crate knows them).
    Builtin(String),
}

/// Keys of a scene file's `[environment]` that [`EnvironmentSettings`] come from; the others are options of whoever draws.
pub const ENVIRONMENT_KEYS: [&str; 3] = ["file", "builtin", "exposure"];

/// The environment that a scene file brings.
#[derive(Clone, Debug, PartialEq)]
pub struct EnvironmentSettings {
    /// Which; none where a light rig stands in its place.
    pub source: Option<EnvironmentSource>,
    /// Exposure of the displayed picture [stops]; `None` asks for what suits the environment.
    pub exposure_ev: Option<f32>,
}

/// A scene with what its file says beside geometry.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadedScene {
    /// Geometry, materials, cameras, warnings. Its ground is not added yet.
    pub scene: Scene,
    /// The environment, where the file names one.
    pub environment: Option<EnvironmentSettings>,
    /// The ground that the file asks for, or else its format's default: pass it to [`Scene::add_ground`].
    pub ground: Ground,
    /// The material variant that is shown, by its name: the one that was asked for, or else the scene file's.
    pub variant: Option<String>,
    /// Axes and unit that were taken for files that do not say: those of [`LoadOptions::axes`], or else of the scene file.
    pub axes: Axes,
}

/// Reads a scene file. The format is told by the file name's extension; where the content starts like another format,
/// the content decides and the scene carries a warning.
///
/// Whatever the bytes are, this ends in a scene or one [`SceneFileError`]: in a scene, every index is in range, every
/// coordinate is finite, and node transforms stay finite down the hierarchy.
pub fn load(path: &Path, options: &LoadOptions) -> Result<LoadedScene, SceneFileError> {
    load_from(path, &FileResolver, options)
}

/// [`load`] of a file that `resolver` gives, with all that it names.
///
/// # Errors
/// As [`load`].
pub fn load_from(
    path: &Path,
    resolver: &dyn Resolver,
    options: &LoadOptions,
) -> Result<LoadedScene, SceneFileError> {
    let mut budget = Budget::new(options.memory_limit);
    load_within(path, (resolver, options), &mut budget, true)
}

/// [`load`] of bytes that are no file, or not yet: `name` stands for their path, in messages, for the format and for the paths of the
/// files that they name, which `resolver` gives.
///
/// # Errors
/// As [`load`].
pub fn load_bytes(
    name: &Path,
    bytes: &[u8],
    resolver: &dyn Resolver,
    options: &LoadOptions,
) -> Result<LoadedScene, SceneFileError> {
    let mut budget = Budget::new(options.memory_limit);
    budget.take(bytes.len(), 1).map_err(|fault| fault.at(name))?;
    let source = Source { path: name, bytes, resolver, options };
    read(&source, &mut budget, true)
}

/// [`load`] on what is left of a budget; `scene_files` is false inside a scene file, which may place models only.
fn load_within(
    path: &Path,
    (resolver, options): (&dyn Resolver, &LoadOptions),
    budget: &mut Budget,
    scene_files: bool,
) -> Result<LoadedScene, SceneFileError> {
    let bytes = read_file(path, resolver, budget).map_err(|fault| fault.at(path))?;
    read(&Source { path, bytes: &bytes, resolver, options }, budget, scene_files)
}

fn read(source: &Source, budget: &mut Budget, scene_files: bool) -> Result<LoadedScene, SceneFileError> {
    let Source { path, bytes, .. } = *source;
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    let by_name = FORMATS.iter().find(|format| format.extensions.contains(&extension.as_str()));
    let by_content = FORMATS.iter().find(|format| (format.recognise)(bytes));
    // A format without a signature (OBJ, TOML) is believed unless the content is clearly another's.
    let format = by_content.or(by_name).ok_or_else(|| SceneFileError::UnknownFormat {
        path: path.to_owned(),
        known: FORMATS
            .iter()
            .map(|f| format!("{} .{}", f.name, f.extensions.join(" .")))
            .collect::<Vec<_>>()
            .join(", "),
    })?;
    if !scene_files && format.extensions.contains(&"toml") {
        let message = "a scene file cannot place another scene file, only models".to_owned();
        return Err(SceneFileError::Unsupported { path: path.to_owned(), message });
    }
    let mut loaded = (format.read)(source, budget).map_err(|fault| fault.at(path))?;
    if format.has_axes && !source.options.axes.are_own() {
        let warning = format!("{} has its own axes and metres: 'up' and 'unit' have no effect", format.name);
        loaded.scene.warnings.push(warning);
    }
    if let Some(named) = by_name.filter(|named| named.name != format.name) {
        loaded
            .scene
            .warnings
            .push(format!("the file is named like {} but holds {}", named.name, format.name));
    }
    loaded.variant = source.options.variant.clone().or(loaded.variant);
    if let Some(variant) = loaded.variant.as_ref().filter(|_| scene_files) {
        check_variant(variant, &loaded.scene).map_err(|fault| fault.at(path))?;
    }
    tidy(&mut loaded.scene.warnings);
    loaded.scene.check_extent().map_err(|message| Fault::Invalid(message).at(path))?;
    // A model of a scene file stands on that file's ground.
    if scene_files
        && loaded.ground == Ground::Fade
        && format.default_ground == Ground::Fade
        && loaded.scene.brings_ground()
    {
        loaded.ground = Ground::None;
    }
    Ok(loaded)
}

/// Refuses a variant that no model of a scene has.
fn check_variant(variant: &str, scene: &Scene) -> Result<(), Fault> {
    let known = &scene.variants;
    if known.iter().any(|name| name == variant) {
        return Ok(());
    }
    let known = if known.is_empty() {
        "there are none".to_owned()
    } else {
        format!("there are: {}", known.join(", "))
    };
    let variant = gnomon_messages::quoted(variant);
    Err(Fault::Unsupported(format!("it has no material variant '{variant}' ({known})")))
}

/// Each warning once, and no more of them than anybody reads.
fn tidy(warnings: &mut Vec<String>) {
    const MOST: usize = 20;
    let mut seen = HashSet::new();
    warnings.retain(|warning| seen.insert(warning.clone()));
    if warnings.len() > MOST {
        let more = warnings.len() - MOST;
        warnings.truncate(MOST);
        warnings.push(format!("and {more} more warnings"));
    }
}

/// A file's bytes and where they are from.
struct Source<'a> {
    path: &'a Path,
    bytes: &'a [u8],
    resolver: &'a dyn Resolver,
    options: &'a LoadOptions,
}

impl Source<'_> {
    /// Path of a file that this one names relative to itself.
    fn sibling(&self, relative: &str) -> PathBuf {
        self.path.parent().unwrap_or(Path::new("")).join(relative)
    }

    /// Bytes of a file that this one names, within the budget.
    fn read(&self, path: &Path, budget: &mut Budget) -> Result<Vec<u8>, Fault> {
        read_file(path, self.resolver, budget)
    }

    /// Path and bytes of a file that this one names, as programs on any system write names: `\\` may stand for `/`, and a path may be one on
    /// another machine, of which the last part counts. All `names` are tried, each in these folders, then beside this file.
    fn find<'a>(
        &self,
        names: impl IntoIterator<Item = &'a str>,
        folders: &[&Path],
        budget: &mut Budget,
    ) -> Result<(PathBuf, Vec<u8>), Fault> {
        let own = self.path.parent().unwrap_or(Path::new(""));
        let mut first = None;
        for name in names.into_iter().filter(|name| !name.is_empty()) {
            let name = name.replace('\\', "/");
            let last = name.rsplit('/').next().filter(|last| last.len() < name.len() && !last.is_empty());
            for name in std::iter::once(name.as_str()).chain(last) {
                for folder in folders.iter().copied().chain([own]) {
                    let path = folder.join(name);
                    match self.read(&path, budget) {
                        Ok(bytes) => return Ok((path, bytes)),
                        Err(fault @ Fault::TooLarge { .. }) => return Err(fault),
                        Err(fault) => first = first.or_else(|| Some(fault.at(&path))),
                    }
                }
            }
        }
        Err(first.map_or_else(|| Fault::invalid("it names no file"), Fault::from))
    }

    /// A scene without environment on the format's default ground.
    fn loaded(&self, scene: Scene, ground: Ground) -> LoadedScene {
        LoadedScene { scene, environment: None, ground, variant: None, axes: self.options.axes }
    }
}

/// Memory that loading may still take: asked before every allocation whose size a file decides.
struct Budget {
    left: usize,
    limit: usize,
}

impl Budget {
    fn new(limit: usize) -> Self {
        Self { left: limit, limit }
    }

    /// Gives back what was claimed and is needed no more.
    fn give_back(&mut self, count: usize, bytes_each: usize) {
        self.left = self.left.saturating_add(count.saturating_mul(bytes_each)).min(self.limit);
    }

    /// Claims `count` items of `bytes_each`.
    fn take(&mut self, count: usize, bytes_each: usize) -> Result<(), Fault> {
        let left = count.checked_mul(bytes_each).and_then(|bytes| self.left.checked_sub(bytes));
        self.left = left.ok_or(Fault::TooLarge { limit_mib: self.limit >> 20 })?;
        Ok(())
    }
}

/// The whole file, within the budget.
fn read_file(path: &Path, resolver: &dyn Resolver, budget: &mut Budget) -> Result<Vec<u8>, Fault> {
    let bytes = resolver.read(path, budget.left).map_err(|error| match error {
        ReadError::Io(source) => SceneFileError::Io { path: path.to_owned(), source }.into(),
        ReadError::NotRegular => Fault::invalid("it is not a regular file"),
        ReadError::TooLong => Fault::TooLarge { limit_mib: budget.limit >> 20 },
    })?;
    budget.take(bytes.len(), 1)?;
    Ok(bytes)
}

/// Text after a UTF-8 byte order mark.
fn without_bom(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)
}

/// The file's name without folder and extension, to name its node.
fn stem(path: &Path) -> String {
    path.file_stem().map(|stem| gnomon_messages::quoted(&stem.to_string_lossy())).unwrap_or_default()
}
