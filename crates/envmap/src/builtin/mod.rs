//! Environments made by code, to start without a file. Radiance is relative: a white matte surface that faces the room's
//! windows or the sun is near 1.

mod room;
mod sky;
mod studio;

use crate::Equirect;

/// Size of the built-in environments, in texels.
const SIZE: (u32, u32) = (1024, 512);

/// A built-in environment.
struct Builtin {
    name: &'static str,
    make: fn(u32, u32) -> Equirect,
}

/// Every built-in environment: a new one is one file here and one line.
const BUILTINS: &[Builtin] = &[
    Builtin { name: "room", make: room::room },
    Builtin { name: "sky", make: sky::sky },
    Builtin { name: "evening", make: sky::evening },
    Builtin { name: "studio", make: studio::studio },
];

/// Names of the built-in environments.
pub fn names() -> impl Iterator<Item = &'static str> {
    BUILTINS.iter().map(|builtin| builtin.name)
}

/// The built-in environment of that name, 1024 x 512 texels.
pub fn by_name(name: &str) -> Option<Equirect> {
    sized(name, SIZE.0, SIZE.1)
}

/// The same in another size (each side at least 1). Flux does not depend on it but for the sampling of edges.
pub fn sized(name: &str, width: u32, height: u32) -> Option<Equirect> {
    let builtin = BUILTINS.iter().find(|builtin| builtin.name == name)?;
    Some((builtin.make)(width.max(1), height.max(1)))
}
