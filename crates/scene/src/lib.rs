//! Scenes: meshes, materials, cameras, area lights, and the files they come from.
//!
//! [`load`] reads a file of any format that [`formats`] lists, [`builtin::by_name`] makes a scene by code. A [`Scene`] holds its current pose: [`Scene::animate`]
//! takes another. What a file does not say is decided by [`default_camera`] and [`Scene::add_ground`]. CPU shading reads a hit through
//! [`Scene::surface_at`].

mod animation;
pub mod builtin;
mod camera;
mod error;
mod framing;
mod light;
mod load;
mod material;
mod parts;
mod pose;
mod reflectance;
mod scene;
mod shade_inputs;
mod simplify;
mod smooth;
mod texture;

pub use animation::{AnimatedNode, Animation, Channel, Interpolation, Keys};
pub use camera::{Camera, Projection};
pub use error::SceneError;
pub use framing::{Ground, SUNKEN, camera_around, default_camera};
pub use light::{AreaLight, AreaLightShape, PlacedLight};
pub use load::{
    EnvironmentSettings, EnvironmentSource, Format, LoadOptions, LoadedScene, formats, load, read_sections,
};
pub use material::{AlphaMode, Material, Texture, TextureId, TextureRef, Wrap};
pub use parts::MeshPart;
pub use pose::{Influences, Instance, MorphTarget, Pose, Skin, WorldVertices};
pub use reflectance::ReflectanceSettings;
pub use scene::{Bounds, CameraMount, MaterialId, Mesh, MeshId, Node, NodeId, Scene, SkinId};
pub use shade_inputs::{SurfacePoint, normal_matrix, perturb_normal};
pub use simplify::SimplerTriangles;
