//! Scenes of which no byte comes from the file system.

#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests fail the test")]

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use glam::Vec3;
use gnomon_options::Given;
use gnomon_picture::RgbImage;
use gnomon_renderer::{Gpu, GpuOptions};
use gnomon_scene_files::EnvironmentSource;
use gnomon_studio::{
    Look, Project, SceneFiles, SceneSource, Stage, Studio, StudioError, Update, environment_named,
};

const GLTF: &str = r#"{
    "asset": {"version": "2.0"},
    "scenes": [{"nodes": [0]}],
    "nodes": [{"mesh": 0}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "material": 0}]}],
    "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
    "textures": [{"source": 0}],
    "images": [{"uri": "textures/checker.png"}],
    "buffers": [{"uri": "data/triangle.bin", "byteLength": 60}],
    "bufferViews": [
        {"buffer": 0, "byteOffset": 0, "byteLength": 36},
        {"buffer": 0, "byteOffset": 36, "byteLength": 24}
    ],
    "accessors": [
        {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]},
        {"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC2"}
    ]
}"#;

const SCENE: &str = "ground = \"plane\"\n\
    [environment]\nfile = \"maps/sky.exr\"\nrotation = 20\n\
    [render]\nsupersample = 1\nshadow_resolution = 64\n[fit]\nlight_count = 8\n\
    [[model]]\nfile = \"models/triangle.gltf\"\n\
    [[model]]\nfile = \"models/part.obj\"\ntranslation = [1, 0, 0]\n";

const MODEL: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

/// All files of the scene, by their paths.
fn files(sky: Vec3) -> HashMap<PathBuf, Vec<u8>> {
    let folder = tempfile::tempdir().unwrap();
    let picture = |name: &str, picture: RgbImage| {
        let path = folder.path().join(name);
        gnomon_picture::write(&path, &picture).unwrap();
        std::fs::read(path).unwrap()
    };
    let checker = picture("checker.png", RgbImage::from_fn(4, 4, |x, y| Vec3::splat(((x + y) % 2) as f32)));
    let sky = picture("sky.exr", RgbImage::from_fn(64, 32, |x, _| if x < 8 { 20.0 * sky } else { sky }));
    let numbers = [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0];
    let numbers = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
    let text = |text: &str| text.as_bytes().to_vec();
    HashMap::from(
        [
            ("scene.toml", text(SCENE)),
            ("models/triangle.gltf", text(GLTF)),
            ("models/data/triangle.bin", numbers),
            ("models/textures/checker.png", checker),
            ("models/part.obj", text(MODEL)),
            ("maps/sky.exr", sky),
        ]
        .map(|(path, bytes)| (path.into(), bytes)),
    )
}

fn open(source: SceneSource) -> Result<Project, StudioError> {
    Project::open_source(source, Look::default(), &Given::default())
}

fn given(path: &str, files: &HashMap<PathBuf, Vec<u8>>) -> SceneSource {
    SceneSource::Files(SceneFiles::new(path, files.clone()))
}

#[test]
fn scenes_from_memory_are_the_scenes_of_files() {
    let files = files(Vec3::new(0.2, 0.3, 0.5));
    let folder = tempfile::tempdir().unwrap();
    for (path, bytes) in &files {
        let path = folder.path().join(path);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, bytes).unwrap();
    }
    for name in ["models/triangle.gltf", "scene.toml"] {
        let mut from_files = open(SceneSource::File(folder.path().join(name))).unwrap();
        let mut from_memory = open(given(name, &files)).unwrap();
        assert!(from_memory.scene.warnings.is_empty(), "{:?}", from_memory.scene.warnings);
        assert_eq!(from_memory.scene, from_files.scene, "{name}");
        assert_eq!(from_memory.scene.textures.len(), 1);
        if name == "scene.toml" {
            assert_eq!(from_memory.look.fit.light_count, Some(8), "what the file says of how it is drawn");
            let source = EnvironmentSource::File("maps/sky.exr".into());
            assert_eq!(from_memory.look.map, Some(source));
        } else {
            from_files.look.set_environment(environment_named("room"));
            from_memory.look.set_environment(environment_named("room"));
        }
        let stages = [from_files, from_memory].map(|project| Stage::new(project).unwrap());
        assert_eq!(stages[0].scene(), stages[1].scene());
        assert_eq!(stages[0].environment().radiance(), stages[1].environment().radiance());
        let error = stages[1].save_scene(&folder.path().join("saved.toml")).unwrap_err().to_string();
        assert!(error.contains("a program gave its files"), "{error}");
        // A text for a place beside them names them.
        let beside = folder.path().join(name).with_file_name("beside.toml");
        std::fs::write(&beside, stages[1].scene_file().unwrap()).unwrap();
        let again = Stage::new(open(SceneSource::File(beside)).unwrap()).unwrap();
        assert_eq!(again.environment().radiance(), stages[1].environment().radiance());
        assert_eq!(again.look().fit, stages[1].look().fit);
        let seen = |stage: &Stage| (stage.scene().triangle_count(), stage.scene().bounds());
        assert_eq!(seen(&again), seen(&stages[1]));
    }
}

#[test]
fn what_is_missing_in_memory_is_named_and_not_looked_for_elsewhere() {
    let mut files = files(Vec3::ONE);
    let missing = |files: &HashMap<_, _>| match open(given("scene.toml", files)).and_then(Stage::new) {
        Err(error) => error.to_string(),
        Ok(_) => panic!("nothing was missed"),
    };
    for path in ["maps/sky.exr", "models/data/triangle.bin", "scene.toml"] {
        files.remove(Path::new(path));
        let error = missing(&files);
        assert!(error.starts_with("cannot read ") && error.contains(path), "{error}");
    }
}

#[test]
fn a_live_session_takes_scenes_from_memory_each_with_its_own_files() {
    let gpu = match Gpu::new(&GpuOptions::default()) {
        Ok(gpu) => gpu,
        Err(error) => return gnomon_testing::skip(&error.to_string()),
    };
    let mut project = Project::open("column", Look::default(), &Given::default()).unwrap();
    project.look.set_environment(environment_named("room"));
    project.look.techniques.supersample = 1;
    let mut studio = Studio::new(&gpu, Stage::new(project).unwrap()).unwrap();
    // The second one's map has the name of the first one's.
    for sky in [Vec3::new(0.2, 0.3, 0.5), Vec3::new(0.5, 0.1, 0.1)] {
        let source = given("scene.toml", &files(sky));
        studio.load_scene(source.clone());
        let updates = studio.wait();
        assert!(matches!(&updates[..], [Update::Scene]), "{updates:?}");
        let mut project = open(source).unwrap();
        project.look.picture = studio.look().picture.clone();
        let mut opened = Studio::new(&gpu, Stage::new(project).unwrap()).unwrap();
        let [live, opened] = [&mut studio, &mut opened].map(|studio| studio.frame(48, 36).unwrap().radiance);
        assert!(live == opened, "{sky}");
        // Another fit needs no file.
        studio.edit(|look| look.fit.light_count = Some(6)).unwrap();
        assert!(matches!(&studio.wait()[..], [Update::Lighting]));
        studio.reload_environment();
        assert!(matches!(&studio.wait()[..], [Update::Lighting]));
        studio.edit(|look| look.fit.light_count = Some(8)).unwrap();
        studio.wait();
    }
    // A scene without an environment of its own keeps the one that is there, wherever it came from.
    let map = studio.environment().clone();
    studio.load_scene(SceneSource::Builtin("three-boxes".to_owned()));
    let updates = studio.wait();
    assert!(matches!(&updates[..], [Update::Scene]), "{updates:?}");
    assert_eq!(studio.environment().radiance(), map.radiance());
}
