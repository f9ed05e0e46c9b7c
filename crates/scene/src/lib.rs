//! Scenes: meshes, materials, cameras, and the files they come from.

mod camera;
mod material;
mod scene;
mod shade_inputs;
mod texture;

pub use camera::{Camera, Projection};
pub use material::{AlphaMode, Material, Texture, TextureId, TextureRef, Wrap};
pub use scene::{Bounds, MaterialId, Mesh, MeshId, Node, NodeId, Scene};
pub use shade_inputs::{SurfacePoint, perturb_normal};
pub use texture::linear_from_srgb;
