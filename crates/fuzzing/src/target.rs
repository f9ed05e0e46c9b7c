use std::path::Path;

use gnomon_envmap::LoadOptions as MapOptions;
use gnomon_picture::{Description, EnvironmentAttribute, TexelSink};
use gnomon_scene_files::{LoadOptions, ReadError, Resolver, load_bytes};

/// A reader that takes bytes.
#[derive(Clone, Copy)]
pub struct Target {
    /// A file name extension, but for those of [`targets`] that are said to be others.
    pub name: &'static str,
    /// File name extensions of files to start from.
    pub extensions: &'static [&'static str],
    read: fn(&'static str, &[u8]),
}

impl Target {
    /// Reads the bytes. That they make sense is not asked for, but that reading ends: without panic, in time, in bounded memory.
    pub fn run(&self, bytes: &[u8]) {
        (self.read)(self.name, bytes);
    }
}

/// Every picture and scene format under its usual extension, `map` for pictures as environments, `mtl` for the materials of an OBJ, `ies` for lamps, measured
/// reflectances and `tables` that are made of them.
pub fn targets() -> Vec<Target> {
    let pictures =
        gnomon_picture::formats().iter().map(|format| (format.extensions, picture as fn(_, &[u8])));
    let scenes =
        gnomon_scene_files::formats().iter().map(|format| (format.extensions, scene as fn(_, &[u8])));
    let formats = pictures.chain(scenes);
    let mut targets: Vec<Target> = formats
        .filter_map(|(extensions, read)| Some(Target { name: extensions.first()?, extensions, read }))
        .collect();
    targets.push(Target { name: "map", extensions: &["exr", "hdr", "png", "jpg"], read: map });
    targets.push(Target { name: "mtl", extensions: &["mtl"], read: materials });
    targets.push(Target { name: "ies", extensions: &["ies"], read: lamp });
    targets.push(Target { name: "bsdf", extensions: &["bsdf"], read: measurement });
    targets.push(Target { name: "binary", extensions: &["binary"], read: measurement });
    targets.push(Target { name: "tables", extensions: &["tables"], read: tables });
    targets
}

/// The target of that name.
pub fn target(name: &str) -> Option<Target> {
    targets().into_iter().find(|target| target.name == name)
}

/// [`Target::run`] of the target of that name, if there is one.
pub fn run(name: &str, bytes: &[u8]) {
    if let Some(target) = target(name) {
        target.run(bytes);
    }
}

/// Texels that nobody keeps.
struct Nowhere;

impl TexelSink for Nowhere {
    fn begin(&mut self, _width: u32, _height: u32, _environment: Option<EnvironmentAttribute>) {}
    fn texels(&mut self, _x: u32, _y: u32, _texels: &[glam::Vec3]) {}
}

fn picture(_name: &'static str, bytes: &[u8]) {
    let first: Result<Description, _> = gnomon_picture::decode_into(bytes, None, &mut Nowhere);
    // A layer that is asked for goes another way through the names.
    if first.is_err() {
        drop(gnomon_picture::decode_into(bytes, Some("Combined"), &mut Nowhere));
    }
}

fn map(_name: &'static str, bytes: &[u8]) {
    if let Ok(environment) = gnomon_envmap::from_bytes("fuzzed", bytes, MapOptions::default()) {
        let flux = environment.map.flux();
        assert!(flux.is_finite() && flux.min_element() >= 0.0, "a map of flux {flux}");
        drop(environment.warnings());
    }
}

fn scene(name: &'static str, bytes: &[u8]) {
    read_scene(Path::new(&format!("fuzzed.{name}")), bytes, bytes);
}

fn materials(_name: &'static str, bytes: &[u8]) {
    const MODEL: &[u8] = b"mtllib fuzzed.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl a\nf 1/1 2/1 3/1\n";
    read_scene(Path::new("fuzzed.obj"), MODEL, bytes);
}

fn lamp(_name: &'static str, bytes: &[u8]) {
    const LAMP: &[u8] =
        b"[[light]]\nshape = 'spot'\nradius = 1\ntarget = [0, -1, 0]\nprofile = 'fuzzed.ies'\n";
    read_scene(Path::new("lamp.toml"), LAMP, bytes);
}

fn measurement(name: &'static str, bytes: &[u8]) {
    if let Ok(measurement) = gnomon_measured::Measurement::parse(name, bytes) {
        let value = measurement.value(glam::Vec3::new(0.6, 0.0, 0.8), glam::Vec3::new(0.0, -0.28, 0.96));
        assert!(value.is_finite(), "a reflectance of {value}");
    }
}

fn tables(_name: &'static str, bytes: &[u8]) {
    if let Ok(tables) = gnomon_measured::parse(bytes) {
        assert!(tables.most() >= 0.0, "tables that reflect {}", tables.most());
    }
}

fn read_scene(path: &Path, bytes: &[u8], others: &[u8]) {
    let options = LoadOptions::default();
    if let Ok(loaded) = load_bytes(path, bytes, &Siblings(others), &options) {
        let triangles = loaded.scene.triangle_count();
        let bounds = loaded.scene.bounds();
        assert!(
            triangles == 0 || bounds.is_none_or(|bounds| bounds.min.is_finite() && bounds.max.is_finite())
        );
    }
}

/// Whatever a scene names: materials are these bytes, pictures a small one, and all else bytes enough for small buffers.
struct Siblings<'a>(&'a [u8]);

impl Resolver for Siblings<'_> {
    fn read(&self, path: &Path, most: usize) -> Result<Vec<u8>, ReadError> {
        let extension = path.extension().map(|extension| extension.to_ascii_lowercase()).unwrap_or_default();
        let bytes = match extension.to_str() {
            Some("mtl" | "ies") => self.0.to_vec(),
            Some("png" | "jpg" | "jpeg") => crate::seeds::small_png(),
            Some("obj") => b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".to_vec(),
            // A scene that places itself would not end.
            _ if path == Path::new("fuzzed.toml") => return Err(ReadError::NotRegular),
            _ => (0..1_u32 << 14).flat_map(|i| (i as f32 * 0.37).to_le_bytes()).collect(),
        };
        if bytes.len() <= most { Ok(bytes) } else { Err(ReadError::TooLong) }
    }
}
