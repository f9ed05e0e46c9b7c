use std::fmt::{self, Write};

use bytemuck::cast_slice;
use gnomon_picture::RgbImage;
use gnomon_scene::Scene;

/// A 64-bit FNV-1a hash (Fowler, Noll and Vo): tells what has changed by accident, not what was forged.
pub struct Digest(u64);

impl Default for Digest {
    fn default() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }
}

impl fmt::Display for Digest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:016x}", self.0)
    }
}

impl Write for Digest {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.update(text.as_bytes());
        Ok(())
    }
}

impl Digest {
    fn update(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }

    /// Bytes and their number, so that what follows is not taken for their end.
    pub fn add(&mut self, bytes: &[u8]) {
        self.update(&(bytes.len() as u64).to_le_bytes());
        self.update(bytes);
    }

    /// What is drawn of a scene, whatever its files are called and whenever they were written.
    pub fn add_scene(&mut self, scene: &Scene) {
        for mesh in &scene.meshes {
            self.add(cast_slice(&mesh.positions));
            self.add(cast_slice(&mesh.normals));
            self.add(cast_slice(&mesh.tangents));
            self.add(cast_slice(&mesh.uvs[0]));
            self.add(cast_slice(&mesh.uvs[1]));
            self.add(cast_slice(&mesh.colors));
            self.add(cast_slice(&mesh.triangles));
            self.add_debug(&(&mesh.material, &mesh.influences, &mesh.targets));
        }
        for texture in &scene.textures {
            self.add(cast_slice(&texture.rgba8));
            self.add_debug(&(texture.width, texture.height, texture.wrap, texture.nearest));
        }
        for map in &scene.height_maps {
            self.add_debug(map);
        }
        self.add_debug(&(&scene.materials, &scene.nodes, &scene.lights, &scene.cameras));
        self.add_debug(&(&scene.skins, &scene.animations, &scene.animated, &scene.camera_mounts));
    }

    /// The texels of a picture.
    pub fn add_picture(&mut self, picture: &RgbImage) {
        self.add(&[picture.width().to_le_bytes(), picture.height().to_le_bytes()].concat());
        self.add(cast_slice(picture.texels()));
    }

    fn add_debug(&mut self, value: &impl fmt::Debug) {
        // Only a writer that fails makes formatting fail.
        let _ = write!(self, "{value:?};");
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;

    #[test]
    fn values_of_the_authors() {
        // draft-eastlake-fnv, appendix C.
        for (text, hash) in
            [("", 0xcbf2_9ce4_8422_2325), ("a", 0xaf63_dc4c_8601_ec8c), ("foobar", 0x8594_4171_f739_67e8)]
        {
            let mut digest = Digest::default();
            digest.update(text.as_bytes());
            assert_eq!(digest.0, hash);
        }
    }

    #[test]
    fn any_part_of_a_scene_counts() {
        let digest = |scene: &Scene| {
            let mut digest = Digest::default();
            digest.add_scene(scene);
            digest.to_string()
        };
        let scene = gnomon_scene::builtin::by_name("three-boxes").unwrap();
        let same = digest(&scene);
        assert_eq!(digest(&scene.clone()), same);
        let changes: [fn(&mut Scene); 4] = [
            |scene| Arc::make_mut(&mut scene.meshes[0]).positions[3].x += 1e-6,
            |scene| scene.materials[0].surface.base_color.y += 1e-6,
            |scene| scene.nodes[0].parent_from_node.translation.z += 1e-6,
            |scene| Arc::make_mut(&mut scene.meshes[0]).triangles.swap(0, 1),
        ];
        for change in changes {
            let mut changed = scene.clone();
            change(&mut changed);
            assert_ne!(digest(&changed), same);
        }
    }
}
