//! Scenes: meshes, materials, cameras, and the files they come from.

mod camera;
mod material;
mod scene;

pub use camera::{Camera, Projection};
pub use material::{AlphaMode, Material, Texture, TextureId, TextureRef, Wrap};
pub use scene::{Bounds, MaterialId, Mesh, MeshId, Node, NodeId, Scene};
