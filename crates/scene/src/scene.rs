use std::sync::Arc;

use glam::{Affine3A, DVec3, Mat3, Vec2, Vec3, Vec4};

use crate::{
    AnimatedNode, Animation, AreaLight, Camera, HeightMap, Influences, Material, MorphTarget, SceneError,
    Skin, Texture, TextureRef,
};

/// Index into [`Scene::meshes`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct MeshId(pub usize);

/// Index into [`Scene::materials`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct MaterialId(pub usize);

/// Index into [`Scene::nodes`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct NodeId(pub usize);

/// Index into [`Scene::skins`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct SkinId(pub usize);

/// Triangles of one material. All vertex arrays are as long as `positions`, or empty where marked.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Mesh {
    /// Positions in mesh space [m].
    pub positions: Vec<Vec3>,
    /// Unit shading normals in mesh space. Loaders make flat ones (vertices unshared) where the file has none; without any a mesh is flat
    /// as well, as large ones are left.
    pub normals: Vec<Vec3>,
    /// Unit tangents with the bitangent's sign in w; empty unless the material needs them: for a normal
    /// texture, or an anisotropic reflectance.
    pub tangents: Vec<Vec4>,
    /// Up to two texture coordinate sets; a missing set is empty.
    pub uvs: [Vec<Vec2>; 2],
    /// Linear vertex colours that multiply the base colour; empty where there are none.
    pub colors: Vec<Vec4>,
    /// Vertex indices, counter-clockwise seen from the front; every index is in range.
    pub triangles: Vec<[u32; 3]>,
    /// Material; `None` is [`Material::default`].
    pub material: Option<MaterialId>,
    /// Whether lights of the scene stand for its emission ([`Scene::light_emission`]): reflections show those.
    pub shines: bool,
    /// Joints that bend the vertices where a node gives the mesh a skin; empty for most.
    pub influences: Influences,
    /// Morph targets; empty for most.
    pub targets: Vec<MorphTarget>,
}

/// A place in the hierarchy. Parents come before children in [`Scene::nodes`].
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Node {
    /// Name in the file, empty where it has none.
    pub name: String,
    /// Parent, `None` for a root; always an earlier node.
    pub parent: Option<NodeId>,
    /// Transform to the parent's space.
    pub parent_from_node: Affine3A,
    /// Where the origin of the node's space lies in the space that its file means [m]: 0 but in scenes that were moved, as [`Scene::origin`].
    pub origin: DVec3,
    /// Meshes placed here (one for each primitive of a glTF mesh).
    pub meshes: Vec<MeshId>,
    /// Skin that bends its meshes, which then do not follow the node but the skin's joints.
    pub skin: Option<SkinId>,
    /// Weights of its meshes' morph targets in the current pose; missing ones are 0.
    pub weights: Vec<f32>,
}

/// A camera that a node carries.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CameraMount {
    /// Index into [`Scene::cameras`].
    pub camera: usize,
    /// The node whose place and direction it takes.
    pub node: NodeId,
}

/// Everything that is drawn, and from where, in its current pose: [`Scene::animate`] changes the pose.
///
/// A clone shares meshes, textures and clips with its original; `Arc::make_mut` gives a scene its own copy of one that is to change.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Scene {
    /// Where the origin of world space lies in the coordinates of the scene's file [m]: 0 but for scenes that lie far from there for their
    /// size, which are moved to keep their digits. [`Camera::relative_to`] brings a camera to a scene.
    pub origin: DVec3,
    /// Meshes.
    pub meshes: Vec<Arc<Mesh>>,
    /// Materials.
    pub materials: Vec<Material>,
    /// Textures.
    pub textures: Vec<Arc<Texture>>,
    /// Maps of heights.
    pub height_maps: Vec<Arc<HeightMap>>,
    /// Nodes, parents before children.
    pub nodes: Vec<Node>,
    /// Cameras, in file order; the first is used unless another is named.
    pub cameras: Vec<Camera>,
    /// Area lights, beside the environment; [`Scene::placed_lights`] has them in world space.
    pub lights: Vec<AreaLight>,
    /// Skins.
    pub skins: Vec<Skin>,
    /// Clips, in file order.
    pub animations: Vec<Arc<Animation>>,
    /// The nodes that clips move, each once, with their pose in the file.
    pub animated: Vec<AnimatedNode>,
    /// Cameras that go with nodes.
    pub camera_mounts: Vec<CameraMount>,
    /// The node of the ground that [`Scene::add_ground`] or a built-in scene put under the models: it is drawn like any
    /// other, but does not count in framing.
    pub ground: Option<NodeId>,
    /// Names of the material variants that its files have, one of which may be shown.
    pub variants: Vec<String>,
    /// What the loader repaired or ignored, one line each, for the user to read.
    pub warnings: Vec<String>,
}

/// An axis-aligned box in world space [m].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Smallest corner.
    pub min: Vec3,
    /// Largest corner.
    pub max: Vec3,
}

impl Bounds {
    /// Box around points; `None` without any.
    pub fn around(points: impl IntoIterator<Item = Vec3>) -> Option<Self> {
        points.into_iter().map(|p| Self { min: p, max: p }).reduce(Self::union)
    }

    /// Centre [m].
    pub fn center(&self) -> Vec3 {
        0.5 * (self.min + self.max)
    }

    /// Half the diagonal [m].
    pub fn radius(&self) -> f32 {
        0.5 * (self.max - self.min).length()
    }

    /// Box around both.
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }
}

impl Scene {
    /// Box around every placed triangle corner in the current pose; `None` for a scene without triangles.
    pub fn bounds(&self) -> Option<Bounds> {
        self.bounds_where(|_| true)
    }

    /// The same without the ground; `None` where there is nothing else.
    pub fn bounds_without_ground(&self) -> Option<Bounds> {
        self.bounds_where(|node| Some(node) != self.ground)
    }

    fn bounds_where(&self, counts: impl Fn(NodeId) -> bool) -> Option<Bounds> {
        let pose = self.pose();
        let placed = self.instances_in(&pose.world_from_nodes);
        let counted = placed.iter().filter(|instance| counts(instance.node));
        counted.filter_map(|instance| self.instance_bounds(&pose, instance)).reduce(Bounds::union)
    }

    /// Camera by name, or by its number from 0 where no camera has that name; `None` asks for the first.
    ///
    /// # Errors
    /// [`SceneError::Request`] naming the cameras that exist.
    pub fn camera(&self, name: Option<&str>) -> Result<&Camera, SceneError> {
        let found = match name {
            None => self.cameras.first(),
            Some(name) => self
                .cameras
                .iter()
                .find(|camera| camera.name == name)
                .or_else(|| name.parse::<usize>().ok().and_then(|number| self.cameras.get(number))),
        };
        found.ok_or_else(|| match (name, self.cameras.len()) {
            (None, _) | (_, 0) => SceneError::Request("the scene has no camera".to_owned()),
            (Some(name), _) => {
                let known: Vec<&str> = self.cameras.iter().map(|camera| camera.name.as_str()).collect();
                SceneError::Request(format!(
                    "the scene has no camera '{name}' (there are: {})",
                    known.join(", ")
                ))
            }
        })
    }

    /// Adds a mesh and a root node that places it where it is.
    pub fn push_mesh(&mut self, name: &str, mesh: Mesh) -> NodeId {
        self.meshes.push(Arc::new(mesh));
        self.nodes.push(Node {
            name: name.to_owned(),
            origin: self.origin,
            meshes: vec![MeshId(self.meshes.len() - 1)],
            ..Node::default()
        });
        NodeId(self.nodes.len() - 1)
    }

    /// Adds everything of `other` under a new node `root`, which has no meshes. Cameras follow `root`'s transform, without
    /// its scale. A ground of `other` is then a node like any other; its clips follow those that exist.
    pub fn append(&mut self, other: Self, root: Node) {
        let translation = Vec3::from(root.parent_from_node.translation).as_dvec3();
        self.append_at(other, root, translation);
        self.move_origin(self.origin, &[]);
    }

    /// The same with the translation of `root` in double precision, from file coordinates to file coordinates, where one of the scenes was
    /// moved from there. Cameras of `other` keep an origin of their own, and so their digits, until [`Scene::move_origin`].
    pub fn append_at(&mut self, other: Self, mut root: Node, translation: DVec3) {
        let (meshes, materials) = (self.meshes.len(), self.materials.len());
        let height_maps = self.height_maps.len();
        let (textures, first) = (self.textures.len(), self.nodes.len() + 1);
        let (skins, cameras) = (self.skins.len(), self.cameras.len());
        let moved_texture = |texture: &mut Option<TextureRef>| {
            if let Some(texture) = texture {
                texture.texture.0 += textures;
            }
        };
        self.textures.extend(other.textures);
        self.height_maps.extend(other.height_maps);
        self.materials.extend(other.materials.into_iter().map(|mut material| {
            for texture in material.textures_mut() {
                moved_texture(texture);
            }
            if let Some(height) = &mut material.height {
                height.map.0 += height_maps;
            }
            material
        }));
        self.meshes.extend(other.meshes.into_iter().map(|mut mesh| {
            if let Some(material) = mesh.material.filter(|_| materials > 0) {
                Arc::make_mut(&mut mesh).material = Some(MaterialId(material.0 + materials));
            }
            mesh
        }));
        let (_, rotation, _) = root.parent_from_node.to_scale_rotation_translation();
        let linear = Mat3::from(root.parent_from_node.matrix3);
        self.cameras.extend(other.cameras.into_iter().map(|mut camera| {
            let eye = linear * camera.eye();
            let turned = glam::Mat4::from_quat(rotation) * camera.world_from_camera;
            camera.world_from_camera = turned;
            camera.world_from_camera.w_axis = eye.extend(1.0);
            camera.origin = linear.as_dmat3() * camera.origin + translation;
            camera
        }));
        for variant in other.variants {
            if !self.variants.contains(&variant) {
                self.variants.push(variant);
            }
        }
        self.warnings.extend(other.warnings.into_iter().map(|warning| match root.name.as_str() {
            "" => warning,
            name => format!("{name}: {warning}"),
        }));
        self.lights.extend(other.lights.into_iter().map(|mut light| {
            light.node.0 += first;
            light
        }));
        self.skins.extend(other.skins.into_iter().map(|mut skin| {
            skin.joints.iter_mut().for_each(|joint| joint.0 += first);
            skin
        }));
        self.animations.extend(other.animations.into_iter().map(|mut animation| {
            Arc::make_mut(&mut animation).channels.iter_mut().for_each(|channel| channel.node.0 += first);
            animation
        }));
        self.animated.extend(other.animated.into_iter().map(|mut animated| {
            animated.node.0 += first;
            animated
        }));
        self.camera_mounts.extend(
            other.camera_mounts.into_iter().map(|mount| CameraMount {
                camera: mount.camera + cameras,
                node: NodeId(mount.node.0 + first),
            }),
        );
        root.origin = other.origin;
        self.nodes.push(root);
        self.place(NodeId(first - 1), translation);
        self.nodes.extend(other.nodes.into_iter().map(|mut node| {
            node.parent = Some(NodeId(node.parent.map_or(first - 1, |parent| parent.0 + first)));
            node.meshes.iter_mut().for_each(|mesh| mesh.0 += meshes);
            node.skin = node.skin.map(|skin| SkinId(skin.0 + skins));
            node
        }));
    }

    /// Refuses a scene whose transforms or corners leave the range in which squares of coordinates stay finite.
    ///
    /// # Errors
    /// What lies too far.
    pub fn check_extent(&self) -> Result<(), String> {
        let world = self.world_from_nodes();
        if let Some(node) = world.iter().position(|affine| !affine.is_finite()) {
            return Err(format!("the transforms down to node {node} grow beyond all bounds"));
        }
        let corners = self.bounds().into_iter().flat_map(|bounds| [bounds.min, bounds.max]);
        let lights = self.lights.iter().map(|light| world[light.node.0].translation.into());
        let distance = |place: Vec3| if place.is_nan() { f32::NAN } else { place.abs().max_element() };
        if let Some(far) = corners
            .chain(lights)
            .map(distance)
            .find(|&distance| distance > crate::pose::LARGEST || distance.is_nan())
        {
            return Err(format!("its geometry and lights reach {far:.1e} m from the origin"));
        }
        Ok(())
    }

    /// Number of placed triangles.
    pub fn triangle_count(&self) -> usize {
        self.nodes.iter().flat_map(|node| &node.meshes).map(|mesh| self.meshes[mesh.0].triangles.len()).sum()
    }
}
