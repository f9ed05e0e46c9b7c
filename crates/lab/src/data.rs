use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::{Affine3A, Vec2, Vec3};
use gnomon_brdf::{Model, Surface};
use gnomon_envmap::Equirect;
use gnomon_scene::{
    Camera, Ground, Material, MaterialId, MeshId, Projection, Scene, builtin, default_camera,
};
use gnomon_scene_files::LoadOptions;

use crate::LabError;

/// Width and height of every environment of an experiment [texels]: those of the maps under which the truth pictures of the test data
/// were made.
pub(crate) const ENVIRONMENT_SIZE: (u32, u32) = (512, 256);

/// Width over height of every picture of an experiment.
pub(crate) const ASPECT: f32 = 4.0 / 3.0;

/// A named environment.
#[derive(Clone, Debug)]
pub struct Environment {
    /// Key in tables and file names.
    pub name: &'static str,
    /// Radiance, 512 x 256.
    pub map: Equirect,
    /// The built-in environment that was taken because no file was there.
    pub stand_in: Option<&'static str>,
}

/// A named scene with its ground, and a view of it.
#[derive(Clone, Debug)]
pub struct View {
    /// Key in tables and file names.
    pub name: &'static str,
    /// Models and ground.
    pub scene: Scene,
    /// Whether it stands on a ground, which fits take into account.
    pub stands_on_ground: bool,
    /// The camera, 4 : 3.
    pub camera: Camera,
    /// The built-in scene that was taken because no file was there.
    pub stand_in: Option<&'static str>,
}

impl View {
    /// A scene that is what it claims to be.
    pub(crate) fn new(name: &'static str, scene: Scene, camera: Camera) -> Self {
        Self { name, stands_on_ground: scene.stands_on_ground(), scene, camera, stand_in: None }
    }
}

/// Where something comes from: files relative to the data folder, the first that exists; else a built-in.
struct Source {
    name: &'static str,
    /// None for what is built in itself.
    files: &'static [&'static str],
    stand_in: &'static str,
}

/// Turns that stand a file's model upright and show its side: about +x, then about +y [degrees].
const TURNS: &[(&str, [f32; 2])] = &[("glossy_horse", [-90.0, -114.0])];

impl Source {
    /// The built-in, if that stands for something else.
    fn stand_in(&self) -> Option<&'static str> {
        (!self.files.is_empty()).then_some(self.stand_in)
    }
}

const ENVIRONMENTS: &[Source] = &[
    Source {
        name: "grace",
        files: &["reference/env_grace_latlong_512x256.exr", "env/debevec_grace_cross.hdr"],
        stand_in: "room",
    },
    Source {
        name: "stpeters",
        files: &["reference/env_stpeters_latlong_512x256.exr", "env/debevec_stpeters_cross.hdr"],
        stand_in: "room",
    },
    Source {
        name: "galileo",
        files: &["reference/env_galileo_latlong_512x256.exr", "env/debevec_galileo_cross.hdr"],
        stand_in: "room",
    },
    Source { name: "kitchen", files: &["env/debevec_kitchen_cross.hdr"], stand_in: "room" },
    Source { name: "rnl", files: &["env/debevec_rnl_cross.hdr"], stand_in: "sky" },
    Source { name: "studio", files: &["env/cc0_studio_small_03_1k.hdr"], stand_in: "room" },
    Source { name: "sunny", files: &["env/cc0_spiaggia_di_mondello_1k.hdr"], stand_in: "sky" },
    Source { name: "uffizi", files: &["env/uffizi_latlong_1200x600.hdr"], stand_in: "room" },
    Source { name: "dawn", files: &["env/cc0_kiara_1_dawn_1k.hdr"], stand_in: "sky" },
    Source { name: "park", files: &["env/cc0_rooitou_park_1k.hdr"], stand_in: "sky" },
    Source { name: "sky", files: &[], stand_in: "sky" },
];

const SCENES: &[Source] = &[
    Source { name: "three_boxes", files: &["scenes/three_boxes.glb"], stand_in: "three-boxes" },
    Source { name: "bunny", files: &["scenes/bunny_on_ground.glb"], stand_in: "column" },
    Source { name: "buddha", files: &["models/happy_buddha_res3.ply"], stand_in: "column" },
    Source { name: "footbones", files: &["models/footbones.ply"], stand_in: "column" },
    Source { name: "glossy_bunny", files: &["models/stanford_bunny_35947v.ply"], stand_in: "column" },
    Source { name: "glossy_triceratops", files: &["models/triceratops.obj"], stand_in: "three-boxes" },
    Source { name: "glossy_horse", files: &["models/horse_48485v.ply"], stand_in: "column" },
    Source { name: "brainstem", files: &["models/BrainStem.glb"], stand_in: "column" },
    Source { name: "fox", files: &["models/Fox.glb"], stand_in: "three-boxes" },
    Source { name: "fence", files: &["scenes/fence.glb"], stand_in: "three-boxes" },
    Source { name: "shelf", files: &["scenes/shelf.glb"], stand_in: "three-boxes" },
    Source { name: "tree", files: &["scenes/tree.glb"], stand_in: "column" },
    Source { name: "plaza", files: &["scenes/plaza.glb"], stand_in: "column" },
    Source { name: "terrain", files: &[], stand_in: "terrain" },
];

/// Phong exponents of the models of scenes that are not matte; their ground is.
const SHININESS: &[(&str, f32)] =
    &[("glossy_bunny", 40.0), ("glossy_triceratops", 500.0), ("glossy_horse", 40.0)];

/// Room around a model that fills the picture, as a share of its own extent.
const FILLING_MARGIN: f32 = 0.03;

/// Pictures that an independent renderer made of a scene under an environment, in the data folder.
const TRUTHS: &[(&str, &str, &str)] = &[
    ("three_boxes", "grace", "reference/three_boxes_grace.exr"),
    ("three_boxes", "galileo", "reference/three_boxes_galileo.exr"),
    ("bunny", "stpeters", "reference/bunny_flat_stpeters.exr"),
    ("fence", "grace", "reference/fence_grace.exr"),
    ("shelf", "grace", "reference/shelf_grace.exr"),
    ("tree", "stpeters", "reference/tree_stpeters.exr"),
    ("plaza", "galileo", "reference/plaza_galileo.exr"),
];

/// The external test data, or its absence.
#[derive(Clone, Debug, Default)]
pub struct DataFolder(pub Option<PathBuf>);

impl DataFolder {
    fn find(&self, files: &[&str]) -> Option<PathBuf> {
        let folder = self.0.as_ref()?;
        files.iter().map(|file| folder.join(file)).find(|path| path.is_file())
    }

    /// The file of an environment, where it is there.
    pub(crate) fn environment_file(&self, name: &str) -> Option<PathBuf> {
        self.find(known(ENVIRONMENTS, "environment", name).ok()?.files)
    }

    /// The environment of that name; a built-in one stands in for a file that is absent.
    ///
    /// # Errors
    /// An unknown name, a file that cannot be used.
    pub fn environment(&self, name: &str) -> Result<Environment, LabError> {
        let source = known(ENVIRONMENTS, "environment", name)?;
        let (width, height) = ENVIRONMENT_SIZE;
        let unknown = || LabError::Request(format!("there is no environment '{}'", source.stand_in));
        match self.find(source.files) {
            Some(path) => {
                let map = gnomon_envmap::load(&path, Default::default())?.map.resized(width, height);
                Ok(Environment { name: source.name, map, stand_in: None })
            }
            None => {
                let map =
                    gnomon_envmap::builtin::sized(source.stand_in, width, height).ok_or_else(unknown)?;
                Ok(Environment { name: source.name, map, stand_in: source.stand_in() })
            }
        }
    }

    /// The scene of that name on a ground; a built-in one stands in for a file that is absent.
    ///
    /// # Errors
    /// An unknown name, a file that cannot be used.
    pub fn view(&self, name: &str) -> Result<View, LabError> {
        let source = known(SCENES, "scene", name)?;
        let (mut scene, mut ground, stand_in) = match self.find(source.files) {
            Some(path) => {
                let loaded = gnomon_scene_files::load(
                    &path,
                    &LoadOptions { aspect: ASPECT, ..LoadOptions::default() },
                )?;
                (loaded.scene, loaded.ground, None)
            }
            None => (builtin::by_name(source.stand_in)?, Ground::None, source.stand_in()),
        };
        if let Some((_, turn)) = TURNS.iter().find(|(scene, _)| stand_in.is_none() && *scene == source.name) {
            let [x, y] = turn.map(f32::to_radians);
            let turned = Affine3A::from_rotation_y(y) * Affine3A::from_rotation_x(x);
            for node in scene.nodes.iter_mut().filter(|node| node.parent.is_none()) {
                node.parent_from_node = turned * node.parent_from_node;
            }
        }
        let shininess =
            SHININESS.iter().find(|(scene, _)| *scene == source.name).map(|(_, shininess)| *shininess);
        if let Some(shininess) = shininess {
            make_glossy(&mut scene, shininess);
            // Light from below is part of what a highlight shows; the paper's models have nothing under them.
            ground = Ground::None;
        }
        let mut camera = scene.cameras.first().cloned().unwrap_or_else(|| default_camera(&scene, ASPECT));
        if stand_in.is_none() && shininess.is_some() {
            camera = filling(&scene, &camera);
        }
        scene.add_ground(ground);
        Ok(View { stand_in, ..View::new(source.name, scene, camera) })
    }

    /// A picture of the scene under the environment by an independent renderer: `SCENE_ENVIRONMENT.exr` in `folder`, or one of
    /// the data folder's.
    pub(crate) fn truth(&self, folder: Option<&Path>, scene: &str, environment: &str) -> Option<PathBuf> {
        let given = folder.map(|folder| folder.join(format!("{scene}_{environment}.exr")));
        given.filter(|path| path.is_file()).or_else(|| {
            let listed = TRUTHS.iter().find(|(s, e, _)| (*s, *e) == (scene, environment));
            self.find(&[listed?.2])
        })
    }
}

/// A surface that is nearly all highlight; the paper shows such and does not give its colours.
fn phong(shininess: f32) -> Surface {
    Surface {
        model: Model::Phong,
        shininess,
        base_color: Vec3::splat(0.1),
        specular: 0.8,
        ..Surface::default()
    }
}

/// Gives every mesh but a ground the same Phong surface and, their files having none, smooth normals.
fn make_glossy(scene: &mut Scene, shininess: f32) {
    let name = "glossy".to_owned();
    scene.materials.push(Material {
        name,
        surface: phong(shininess),
        double_sided: true,
        ..Material::default()
    });
    let material = Some(MaterialId(scene.materials.len() - 1));
    let of_ground = scene.ground.and_then(|ground| scene.nodes.get(ground.0)).map(|node| node.meshes.clone());
    for (index, mesh) in scene.meshes.iter_mut().enumerate() {
        if !of_ground.as_ref().is_some_and(|meshes| meshes.contains(&MeshId(index))) {
            let mesh = Arc::make_mut(mesh);
            mesh.material = material;
            mesh.smooth_normals();
        }
    }
}

/// A camera at the same place through whose pinhole the scene just fills the picture, as the paper's models fill theirs.
fn filling(scene: &Scene, camera: &Camera) -> Camera {
    let pose = scene.pose();
    let instances = scene.instances();
    let vertices = || instances.iter().flat_map(|instance| scene.world_vertices(&pose, instance).positions);
    // Corners of what is seen, in the picture plane at distance 1.
    let seen = |camera: &Camera| {
        let camera_from_world = camera.world_from_camera.inverse();
        let places = vertices().map(|vertex| camera_from_world.transform_point3(vertex));
        places.filter(|place| place.z < 0.0).fold(None, |seen: Option<(Vec2, Vec2)>, place| {
            let place = place.truncate() / -place.z;
            let (min, max) = seen.unwrap_or((place, place));
            Some((min.min(place), max.max(place)))
        })
    };
    let Some((min, max)) = seen(camera) else { return camera.clone() };
    let middle = camera.world_from_camera.transform_point3((0.5 * (min + max)).extend(-1.0));
    let aimed = Camera::look_at(camera.eye(), middle, 1.0);
    let Some((min, max)) = seen(&aimed) else { return camera.clone() };
    let half = min.abs().max(max.abs());
    let half_width = half.x.max(half.y * ASPECT) * (1.0 + FILLING_MARGIN);
    Camera { projection: Projection::Perspective { fov_x: 2.0 * half_width.atan() }, ..aimed }
}

fn known(sources: &'static [Source], what: &str, name: &str) -> Result<&'static Source, LabError> {
    sources.iter().find(|source| source.name == name).ok_or_else(|| {
        let names: Vec<_> = sources.iter().map(|source| source.name).collect();
        LabError::Request(format!(
            "the experiments have no {what} '{name}' (they have: {})",
            names.join(", ")
        ))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn built_ins_stand_in_and_say_so() {
        let data = DataFolder(None);
        for source in ENVIRONMENTS {
            let environment = data.environment(source.name).unwrap();
            assert_eq!(environment.stand_in, source.stand_in());
            assert_eq!((environment.map.width(), environment.map.height()), ENVIRONMENT_SIZE);
        }
        for source in SCENES {
            let view = data.view(source.name).unwrap();
            assert_eq!(view.stand_in, source.stand_in());
            assert!(view.scene.ground.is_some() || source.stand_in == "terrain");
        }
        assert!(data.view("terrain").unwrap().stand_in.is_none());
        assert!(data.environment("mars").is_err() && data.view("mars").is_err());
        assert_eq!(data.truth(None, "three_boxes", "grace"), None);
    }

    #[test]
    fn the_stand_in_of_a_glossy_model_keeps_its_matte_ground() {
        let scene = DataFolder(None).view("glossy_bunny").unwrap().scene;
        let surface = |mesh: usize| scene.materials[scene.meshes[mesh].material.unwrap().0].surface;
        let ground = scene.nodes[scene.ground.unwrap().0].meshes[0].0;
        assert_eq!(surface(ground), Surface::default());
        for mesh in (0..scene.meshes.len()).filter(|mesh| *mesh != ground) {
            assert_eq!(surface(mesh), phong(40.0));
        }
    }

    #[test]
    fn files_are_taken_where_they_are() {
        let Some(folder) = gnomon_testing::data_dir() else {
            gnomon_testing::skip("external data is absent (set GNOMON_DATA to its folder)");
            return;
        };
        let data = DataFolder(Some(folder));
        assert_eq!(data.environment("kitchen").unwrap().stand_in, None);
        for scene in SCENES {
            let view = data.view(scene.name).unwrap();
            assert_eq!(view.stand_in, None);
            if scene.name == "glossy_horse" {
                // It stands on its hooves: longer than high, higher than wide.
                let bounds = view.scene.bounds_without_ground().unwrap();
                let size = bounds.max - bounds.min;
                assert!(size.x.hypot(size.z) > size.y && size.y > 0.15, "{size}");
            }
        }
        assert!(data.truth(None, "bunny", "stpeters").is_some());
        assert_eq!(data.truth(None, "bunny", "kitchen"), None);
    }
}
