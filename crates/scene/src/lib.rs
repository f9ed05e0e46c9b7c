//! Scenes: meshes, materials, cameras and area lights, as plain data without files.
//!
//! [`builtin::by_name`] makes a scene by code; the crate `scene-files` reads one. A [`Scene`] holds its current pose: [`Scene::animate`]
//! takes another. [`default_camera`] and [`Scene::add_ground`] give what a file leaves open. The CPU reads a hit through
//! [`Scene::surface_at`].

mod animation;
pub mod builtin;
mod camera;
mod camera_settings;
pub mod edges;
mod emission;
mod error;
mod framing;
mod ground;
mod height;
mod light;
mod material;
mod orbit;
mod origin;
mod parts;
mod pose;
mod reflectance;
mod scene;
mod simplify;
mod smooth;
mod surface_point;
pub mod tangents;
mod texture;
mod triangle;

pub use animation::{AnimatedNode, Animation, Channel, Interpolation, Keys};
pub use camera::{Camera, Film, Projection, rigid};
pub use emission::Emission;
pub use error::SceneError;
pub use framing::{CAMERA_HEIGHT, Ground, SUNKEN, camera_around, default_camera};
pub use ground::{GroundFade, PlacedFade, ground_direction, ground_share};
pub use height::{Gradients, Height, HeightMap, HeightMapId, bent_by_heights};
pub use light::{
    AreaLight, AreaLightShape, FLAT_CLEARANCE, PROFILE_VALUES, PlacedLight, Profile, Spread, cone_share,
};
pub use material::{AlphaMode, Material, Texture, TextureId, TextureRef, Wrap};
pub use orbit::Orbit;
pub use origin::origin_around;
pub use parts::MeshPart;
pub use pose::{Influences, Instance, MorphTarget, Pose, Skin, WorldVertices};
pub use reflectance::{ReflectanceSettings, excess};
pub use scene::{Bounds, CameraMount, MaterialId, Mesh, MeshId, Node, NodeId, Scene, SkinId};
pub use simplify::SimplerTriangles;
pub use surface_point::{SurfacePoint, mirror_sign, normal_matrix, perturb_normal};
pub use triangle::{LARGEST_COORDINATE, triangle_normal};
