//! The options part of the scene format's description is made of the options' declarations.

#![allow(clippy::unwrap_used, reason = "a test fails by it")]

use gnomon_options::markdown;
use gnomon_studio::Look;

const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../scene-files/SCENE_FORMAT.md");
const FROM: &str =
    "<!-- options: made by `GNOMON_UPDATE_DOCS=1 cargo test -p gnomon-studio --test scene_format` -->\n";
const TO: &str = "<!-- end of options -->\n";

#[test]
fn the_description_is_that_of_the_options() {
    let look = Look::default();
    let tables = [
        markdown("", &look.scene),
        markdown("environment", &look.environment),
        markdown("animation", &look.animation),
        markdown("fit", &look.fit),
        markdown("render", &(look.paths, (look.lighting, look.techniques))),
        markdown("display", &(look.picture, look.display)),
    ];
    let text = std::fs::read_to_string(FILE).unwrap();
    let (before, rest) = text.split_once(FROM).unwrap();
    let (_, after) = rest.split_once(TO).unwrap();
    let made = format!("{before}{FROM}{}{TO}{after}", tables.join("\n"));
    if std::env::var_os("GNOMON_UPDATE_DOCS").is_some() {
        std::fs::write(FILE, made).unwrap();
    } else {
        assert!(
            text == made,
            "{FILE} is not what the options' declarations make: run with GNOMON_UPDATE_DOCS=1"
        );
    }
}
