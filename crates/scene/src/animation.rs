//! Clips: how nodes and morph weights change over time (glTF 2.0, section 3.11 and appendix C).

use glam::{Affine3A, Quat, Vec3};

use crate::pose::LARGEST;
use crate::{LARGEST_COORDINATE, NodeId, Scene, SceneError};

/// A clip of a scene: what [`Scene::animate`] plays.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Animation {
    /// Name in the file, empty where it has none.
    pub name: String,
    /// What moves. Where two channels move the same, the later one counts.
    pub channels: Vec<Channel>,
}

/// One property of one node over time.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// The node, which is one of [`Scene::animated`].
    pub node: NodeId,
    /// Times of the keys [s], finite and not decreasing; at least one.
    pub times: Vec<f32>,
    /// What happens between keys.
    pub interpolation: Interpolation,
    /// Values at the keys.
    pub keys: Keys,
}

/// How values between two keys come about (glTF 2.0, appendix C).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Interpolation {
    /// The earlier key's value.
    Step,
    /// Linear; rotations take the shorter arc at constant speed.
    #[default]
    Linear,
    /// Cubic Hermite spline; every key is three values: in-tangent, value, out-tangent.
    CubicSpline,
}

/// Values of a channel: one for each time, three for [`Interpolation::CubicSpline`]. All are finite.
#[derive(Clone, Debug, PartialEq)]
pub enum Keys {
    /// Translation [m].
    Translation(Vec<Vec3>),
    /// Rotation; no key is the zero quaternion.
    Rotation(Vec<Quat>),
    /// Scale along the node's axes.
    Scale(Vec<Vec3>),
    /// Weights of the node's morph targets, all those of a key side by side.
    Weights {
        /// The values.
        values: Vec<f32>,
        /// Number of targets, at least 1.
        targets: usize,
    },
}

/// A node that clips move, with its pose in the file.
#[derive(Clone, Debug, PartialEq)]
pub struct AnimatedNode {
    /// The node.
    pub node: NodeId,
    /// Its transform in the file.
    pub parent_from_node: Affine3A,
    /// The same apart [m]: what a clip does not move keeps these.
    pub translation: Vec3,
    /// Unit quaternion.
    pub rotation: Quat,
    /// Scale along the node's axes.
    pub scale: Vec3,
    /// Weights of its morph targets in the file.
    pub weights: Vec<f32>,
}

impl Animation {
    /// Time of the last key [s]; 0 without one. Clips start at 0: what has its first key later waits in it.
    pub fn duration(&self) -> f32 {
        self.channels.iter().filter_map(|channel| channel.times.last()).fold(0.0, |end, &time| end.max(time))
    }
}

/// What a channel says at one time.
enum Value {
    Translation(Vec3),
    Rotation(Quat),
    Scale(Vec3),
    Weights(Vec<f32>),
}

/// Between which keys a time lies.
struct Span {
    /// The key at or before the time.
    key: usize,
    /// The key after it; the same at either end of the channel.
    next: usize,
    /// Share of the way to `next`, `0..1`.
    share: f32,
    /// Time between the two [s].
    seconds: f32,
}

impl Span {
    fn new(times: &[f32], seconds: f32) -> Self {
        let next = times.partition_point(|&time| time <= seconds);
        let Some(key) = next.checked_sub(1) else {
            return Self { key: 0, next: 0, share: 0.0, seconds: 0.0 };
        };
        if next == times.len() {
            return Self { key, next: key, share: 0.0, seconds: 0.0 };
        }
        // Not empty: the times on either side differ. In double precision it does not overflow either.
        let length = f64::from(times[next]) - f64::from(times[key]);
        let share = ((f64::from(seconds) - f64::from(times[key])) / length) as f32;
        Self { key, next, share, seconds: length as f32 }
    }

    /// The interpolated value, `value(i)` being the channel's number `i` and `mix` its linear interpolation.
    fn value<T>(&self, interpolation: Interpolation, value: impl Fn(usize) -> T, mix: fn(T, T, f32) -> T) -> T
    where
        T: Copy + std::ops::Add<Output = T> + std::ops::Mul<f32, Output = T>,
    {
        match interpolation {
            Interpolation::Step => value(self.key),
            Interpolation::Linear if self.next == self.key => value(self.key),
            Interpolation::Linear => mix(value(self.key), value(self.next), self.share),
            Interpolation::CubicSpline => {
                // Appendix C.5.
                let (t, d) = (self.share, self.seconds);
                let (t2, t3) = (t * t, t * t * t);
                if self.next == self.key {
                    return value(3 * self.key + 1);
                }
                value(3 * self.key + 1) * (2.0 * t3 - 3.0 * t2 + 1.0)
                    + value(3 * self.key + 2) * (d * (t3 - 2.0 * t2 + t))
                    + value(3 * self.next + 1) * (3.0 * t2 - 2.0 * t3)
                    + value(3 * self.next) * (d * (t3 - t2))
            }
        }
    }
}

impl Channel {
    fn at(&self, seconds: f32) -> Value {
        let span = Span::new(&self.times, seconds);
        let vector =
            |values: &[Vec3]| span.value(self.interpolation, |i| values[i], |a, b, t| a + (b - a) * t);
        match &self.keys {
            Keys::Translation(values) => Value::Translation(vector(values)),
            Keys::Scale(values) => Value::Scale(vector(values)),
            Keys::Rotation(values) => {
                // `slerp` takes the shorter arc and wants unit quaternions.
                let mix = |a: Quat, b: Quat, t: f32| a.normalize().slerp(b.normalize(), t);
                let rotation = span.value(self.interpolation, |i| values[i], mix);
                let length = rotation.length();
                // A spline between opposite rotations may pass through zero.
                let usable = length > 0.0 && length.is_finite();
                Value::Rotation(if usable { rotation * length.recip() } else { Quat::IDENTITY })
            }
            Keys::Weights { values, targets } => {
                let weight = |target: usize| {
                    let value = |i: usize| values[i * targets + target];
                    span.value(self.interpolation, value, |a, b, t| a + (b - a) * t)
                };
                Value::Weights((0..*targets).map(weight).collect())
            }
        }
    }
}

impl Scene {
    /// Takes the pose of a clip at a time [s], which is clamped to the clip: every node and morph weight that clips move
    /// stands as this one has it, or else as in the file. To play in a loop, pass `seconds.rem_euclid(duration)`.
    ///
    /// Cameras and area lights on animated nodes go with them. The ground stays where it is.
    ///
    /// # Errors
    /// [`SceneError::Request`] where there is no such clip, the time is not finite, or the pose grows beyond all bounds;
    /// the scene then is at rest.
    pub fn animate(&mut self, animation: usize, seconds: f32) -> Result<(), SceneError> {
        self.animate_all(&[(animation, seconds)])
    }

    /// The same of several clips at once, such as those of several models; where two move the same, the later one counts.
    ///
    /// # Errors
    /// As [`Scene::animate`].
    pub fn animate_all(&mut self, clips: &[(usize, f32)]) -> Result<(), SceneError> {
        self.rest();
        for &(index, seconds) in clips {
            self.check_clip(index, seconds)?;
        }
        let mut places = vec![None; self.nodes.len()];
        for (place, animated) in self.animated.iter().enumerate() {
            places[animated.node.0] = Some(place);
        }
        let mut parts: Vec<_> =
            self.animated.iter().map(|a| (a.translation, a.rotation, a.scale, false)).collect();
        for &(index, seconds) in clips {
            let clip = &self.animations[index];
            let seconds = seconds.clamp(0.0, clip.duration());
            for channel in &clip.channels {
                let Some(place) = places[channel.node.0] else { continue };
                let (translation, rotation, scale, moved) = &mut parts[place];
                match channel.at(seconds) {
                    Value::Translation(value) => (*translation, *moved) = (value, true),
                    Value::Rotation(value) => (*rotation, *moved) = (value, true),
                    Value::Scale(value) => (*scale, *moved) = (value, true),
                    Value::Weights(values) => self.nodes[channel.node.0].weights = values,
                }
            }
        }
        for (animated, (translation, rotation, scale, moved)) in self.animated.iter().zip(parts) {
            if moved {
                let place = Affine3A::from_scale_rotation_translation(scale, rotation, translation);
                self.nodes[animated.node.0].parent_from_node = place;
            }
        }
        self.move_cameras();
        if let Err(message) = self.check_pose() {
            self.rest();
            return Err(SceneError::Request(format!(
                "the animation cannot be shown at this time: {message}"
            )));
        }
        Ok(())
    }

    /// Takes the file's own pose.
    pub fn rest(&mut self) {
        for animated in &self.animated {
            let node = &mut self.nodes[animated.node.0];
            node.parent_from_node = animated.parent_from_node;
            node.weights.clone_from(&animated.weights);
        }
        self.move_cameras();
    }

    pub(crate) fn check_clip(&self, index: usize, seconds: f32) -> Result<(), SceneError> {
        let count = self.animations.len();
        if index >= count {
            let known = if count == 0 { "it has none".to_owned() } else { format!("it has {count}, from 0") };
            return Err(SceneError::Request(format!("the scene has no animation {index}: {known}")));
        }
        if !seconds.is_finite() {
            return Err(SceneError::Request(format!("an animation has no time {seconds} s")));
        }
        Ok(())
    }

    fn move_cameras(&mut self) {
        let animated: Vec<NodeId> = self.animated.iter().map(|animated| animated.node).collect();
        self.take_cameras_along(&animated);
    }

    /// Puts the cameras that are on these nodes, or below them, where their nodes are now. The others keep their digits.
    pub fn take_cameras_along(&mut self, moved: &[NodeId]) {
        if self.camera_mounts.is_empty() || moved.is_empty() {
            return;
        }
        let mut moves = vec![false; self.nodes.len()];
        moved.iter().for_each(|node| moves[node.0] = true);
        for (index, node) in self.nodes.iter().enumerate() {
            moves[index] |= node.parent.is_some_and(|parent| moves[parent.0]);
        }
        let world = self.world_from_nodes();
        for mount in self.camera_mounts.iter().filter(|mount| moves[mount.node.0]) {
            // A collapsed transform has no direction to look along: the camera stays.
            let place = crate::camera::rigid(world[mount.node.0]);
            if let (Some(place), Some(camera)) = (place, self.cameras.get_mut(mount.camera)) {
                camera.world_from_camera = place;
                camera.origin = self.origin;
            }
        }
    }

    /// Refuses a pose whose transforms, weights or corners leave the range in which squares stay finite.
    fn check_pose(&self) -> Result<(), String> {
        let far = |affine: &Affine3A| {
            // False for NaN.
            !affine.to_cols_array().into_iter().all(|entry| entry.abs() <= LARGEST)
        };
        let pose = self.pose();
        if let Some(node) = pose.world_from_nodes.iter().position(far) {
            return Err(format!("the transforms down to node {node} grow beyond all bounds"));
        }
        for (skin, joints) in pose.world_from_bind.iter().enumerate() {
            if let Some(joint) = joints.iter().position(far) {
                return Err(format!("the transforms of joint {joint} of skin {skin} grow beyond all bounds"));
            }
        }
        let weights = || self.nodes.iter().flat_map(|node| &node.weights);
        if weights().any(|weight| weight.is_nan() || weight.abs() > LARGEST) {
            return Err("morph weights grow beyond all bounds".to_owned());
        }
        // Loaders hold corners and offsets within a bound: nearly always that tells without a look at any vertex.
        let placed = pose.world_from_nodes.iter().chain(pose.world_from_bind.iter().flatten());
        let scale =
            placed.flat_map(|affine| affine.matrix3.to_cols_array()).fold(0.0, |a: f32, b| a.max(b.abs()));
        let weight: f32 = weights().map(|weight| weight.abs()).sum();
        if 3.0 * scale * (1.0 + weight) * LARGEST_COORDINATE <= LARGEST {
            return Ok(());
        }
        self.check_extent()
    }
}
