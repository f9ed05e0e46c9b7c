//! What Rust and WGSL share, declared once: structs, constants and the numbers of bind groups.
//!
//! `structs!` and `constants!` make the Rust items and, from the same tokens, the WGSL that [`crate::resolve`] offers as the module
//! `types`. `encase` lays bytes out by WGSL's rules, so that no field is there for padding only; a test compares its offsets with naga's.

use std::sync::LazyLock;

use encase::ShaderType;
use encase::internal::WriteInto;
use glam::{Mat4, UVec2, Vec2, Vec3, Vec4};

mod frame;
mod layers;
mod picture;
mod scene;
mod shadow;
mod tables;

pub use frame::*;
pub use layers::*;
pub use picture::*;
pub use scene::*;
pub use shadow::*;
pub use tables::*;

/// A constant or type whose WGSL follows from the Rust one.
trait InWgsl {
    /// Name of the type.
    fn name() -> String;
}

macro_rules! names {
    ($($ty:ty => $name:literal),*) => {
        $(impl InWgsl for $ty {
            fn name() -> String {
                $name.to_owned()
            }
        })*
    };
}

names!(f32 => "f32", u32 => "u32", UVec2 => "vec2u", Vec2 => "vec2f", Vec3 => "vec3f", Vec4 => "vec4f", Mat4 => "mat4x4f");

impl<T: InWgsl, const N: usize> InWgsl for [T; N] {
    fn name() -> String {
        format!("array<{}, {N}>", T::name())
    }
}

/// A shared struct, for the tests that compare both sides.
pub struct Struct {
    /// The same in Rust and WGSL.
    pub name: &'static str,
    /// Bytes, as `encase` has it.
    pub size: u64,
    /// Names of the members and where `encase` writes them.
    pub members: Vec<(&'static str, u64)>,
    /// The declaration.
    wgsl: String,
}

/// Numbers that both sides know. A file has one block of them.
macro_rules! constants {
    ($($(#[doc = $doc:literal])+ pub const $name:ident: $ty:ident = $value:expr;)+) => {
        $($(#[doc = $doc])+ pub const $name: $ty = $value;)+

        pub(super) fn constants_in_wgsl() -> String {
            let lines = [$(format!("const {}: {} = {}({:?});\n", stringify!($name), stringify!($ty), stringify!($ty), $name)),+];
            lines.concat()
        }
    };
}
use constants;

/// Structs that both sides know. A file has one block of them. `#[size(n)]` gives a member that many bytes, as WGSL's `@size(n)`.
macro_rules! structs {
    ($(
        $(#[doc = $doc:literal])+
        pub struct $name:ident {
            $($(#[doc = $field_doc:literal])+ $(#[size($size:tt)])? pub $field:ident: $ty:ty,)+
        }
    )+) => {
        $(
            $(#[doc = $doc])+
            #[derive(Clone, Copy, Debug, Default, PartialEq, encase::ShaderType)]
            pub struct $name {
                $($(#[doc = $field_doc])+ $(#[shader(size($size))])? pub $field: $ty,)+
            }

            impl super::InWgsl for $name {
                fn name() -> String {
                    stringify!($name).to_owned()
                }
            }
        )+

        pub(super) fn described_structs() -> Vec<super::Struct> {
            vec![$({
                let offsets = <$name as encase::ShaderType>::METADATA.extra.offsets;
                let members = [$(format!("    {}{}: {},\n", concat!($("@size(", $size, ") ")?), stringify!($field), <$ty as super::InWgsl>::name())),+];
                super::Struct {
                    name: stringify!($name),
                    size: <$name as encase::ShaderSize>::SHADER_SIZE.get(),
                    members: [$(stringify!($field)),+].into_iter().zip(offsets).collect(),
                    wgsl: format!("struct {} {{\n{}}}\n", stringify!($name), members.concat()),
                }
            }),+]
        }
    };
}
use structs;

/// Every shared struct.
#[allow(unused_qualifications, reason = "every file has a function of this name")]
pub fn described() -> Vec<Struct> {
    [
        frame::described_structs(),
        layers::described_structs(),
        picture::described_structs(),
        scene::described_structs(),
        shadow::described_structs(),
        tables::described_structs(),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// The module `types`.
#[allow(unused_qualifications, reason = "every file has a function of this name")]
pub(crate) static MODULE: LazyLock<String> = LazyLock::new(|| {
    let constants = [
        frame::constants_in_wgsl(),
        layers::constants_in_wgsl(),
        picture::constants_in_wgsl(),
        scene::constants_in_wgsl(),
        shadow::constants_in_wgsl(),
        tables::constants_in_wgsl(),
    ]
    .concat();
    described().iter().fold(constants, |text, declared| text + &declared.wgsl)
});

/// What can be written to a buffer.
pub trait Shared: ShaderType + WriteInto {}

impl<T: ShaderType + WriteInto + ?Sized> Shared for T {}

/// The bytes of a value, or of a slice of values, as shaders read them.
pub fn bytes<T: Shared + ?Sized>(value: &T) -> Vec<u8> {
    let mut buffer = encase::StorageBuffer::new(Vec::with_capacity(value.size().get() as usize));
    // Only a buffer that cannot grow is too small.
    let _ = buffer.write(value);
    buffer.into_inner()
}

/// Bytes of a `T`.
pub fn size<T: encase::ShaderSize>() -> u64 {
    T::SHADER_SIZE.get()
}
