//! Scenes far from the origin of their files' coordinates, as surveys are.
//!
//! Single precision keeps half a metre of a coordinate of 5,000 km. So such a scene is moved: [`Scene::origin`] is where the origin of its
//! world space lies in file coordinates, [`Node::origin`](crate::Node::origin) the same of a node's space. What people write and read, cameras,
//! lights and places of models, stays in file coordinates, in double precision, and is moved where it meets the scene. Scenes near their origin
//! stay as they are.

use glam::{DMat3, DVec3};

use crate::{NodeId, Scene};

/// A scene is far from the origin where its coordinates are larger than this multiple of its size: single precision then keeps less than a
/// 60,000th of the size, a sixteenth of a pixel in a picture of 4096.
const FAR: f64 = 256.0;

/// Where the origin of a scene should lie whose points have these smallest and largest coordinates: at 0 unless that is far, else near their
/// middle, at multiples of a power of two.
pub fn origin_around(min: DVec3, max: DVec3) -> DVec3 {
    let size = (max - min).max_element();
    let reach = min.abs().max(max.abs()).max_element();
    if !(reach.is_finite() && reach > FAR * size) {
        return DVec3::ZERO;
    }
    let center = 0.5 * (min + max);
    let step = size.log2().ceil().exp2();
    // A single point has no size to round to.
    if step > 0.0 { (center / step).round() * step } else { center }
}

impl Scene {
    /// Where the origin of this scene should lie ([`origin_around`]), in its present coordinates.
    pub fn suitable_origin(&self) -> DVec3 {
        self.bounds().map_or(DVec3::ZERO, |box_| origin_around(box_.min.as_dvec3(), box_.max.as_dvec3()))
    }

    /// Places a node at a translation in its parent's space, both as the file has it.
    pub fn place(&mut self, node: NodeId, translation: DVec3) {
        let parent_origin = self.parent_origin(node);
        let node = &mut self.nodes[node.0];
        let linear: DMat3 = glam::Mat3::from(node.parent_from_node.matrix3).as_dmat3();
        node.parent_from_node.translation = (linear * node.origin + translation - parent_origin).as_vec3a();
    }

    /// The origin of the space that a node is placed in.
    pub fn parent_origin(&self, node: NodeId) -> DVec3 {
        self.nodes[node.0].parent.map_or(self.origin, |parent| self.nodes[parent.0].origin)
    }

    /// Moves the origin, and cameras with it. `places` are the nodes that move, with their translations as the file has them: all roots, and
    /// what is below a node whose own origin has changed.
    pub fn move_origin(&mut self, origin: DVec3, places: &[(NodeId, DVec3)]) {
        self.origin = origin;
        places.iter().for_each(|&(node, translation)| self.place(node, translation));
        self.cameras.iter_mut().for_each(|camera| *camera = camera.relative_to(origin));
    }
}

#[cfg(test)]
mod tests {
    use glam::{Affine3A, Mat3, Vec3};

    use super::*;
    use crate::{Camera, Mesh, Node};

    const FAR_OUT: DVec3 = DVec3::new(500_000.25, 120.5, -4_500_000.75);

    #[test]
    fn only_what_is_far_for_its_size_is_moved() {
        let half = DVec3::new(1.0, 2.0, 0.5);
        for center in [DVec3::ZERO, DVec3::X, 50.0 * DVec3::Y, DVec3::splat(f64::NAN)] {
            assert_eq!(origin_around(center - half, center + half), DVec3::ZERO, "{center}");
        }
        let origin = origin_around(FAR_OUT - half, FAR_OUT + half);
        assert!((origin - FAR_OUT).abs().max_element() <= 2.0 && origin % 4.0 == DVec3::ZERO, "{origin}");
        assert_eq!(origin_around(FAR_OUT, FAR_OUT), FAR_OUT);
    }

    #[test]
    fn a_far_model_is_placed_and_seen_in_the_coordinates_of_its_file() {
        let mut model = Scene { origin: FAR_OUT, ..Scene::default() };
        let mesh = Mesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
            triangles: vec![[0, 1, 2]],
            ..Mesh::default()
        };
        let node = model.push_mesh("triangle", mesh);
        assert_eq!(model.nodes[node.0].origin, FAR_OUT);
        let eye = FAR_OUT + DVec3::new(0.0, 0.0, 3.0);
        let text = |value: DVec3| format!("{},{},{}", value.x, value.y, value.z);
        let camera: Camera = format!("eye={};target={};fov=40", text(eye), text(FAR_OUT)).parse().unwrap();
        model.cameras.push(camera.relative_to(FAR_OUT));
        assert_eq!(model.cameras[0].eye(), Vec3::new(0.0, 0.0, 3.0));
        // Turned by a quarter and moved back to the origin.
        let turn = Affine3A::from_mat3(Mat3::from_cols(Vec3::NEG_Z, Vec3::Y, Vec3::X));
        let root = Node { parent_from_node: turn, ..Node::default() };
        let back = DVec3::new(4_500_000.75, -120.5, 500_000.25);
        let mut scene = Scene::default();
        scene.append_at(model.clone(), root.clone(), back);
        let corners = scene.bounds().unwrap();
        assert_eq!((corners.min, corners.max), (Vec3::NEG_Z, Vec3::Y));
        // And left where it is.
        let mut scene = Scene::default();
        scene.append_at(model, Node::default(), DVec3::ZERO);
        scene.move_origin(FAR_OUT, &[(NodeId(0), DVec3::ZERO)]);
        assert_eq!(scene.bounds().unwrap().max, Vec3::new(1.0, 1.0, 0.0));
        assert_eq!(scene.cameras[0].eye(), Vec3::new(0.0, 0.0, 3.0));
    }
}
