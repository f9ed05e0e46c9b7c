//! A map statement of a material library: options and the name of a picture.

use std::ops::Range;

use glam::{Affine2, Vec2};

use crate::text;

/// A picture and how it lies on the surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Map {
    /// The name as it stands there.
    pub name: String,
    /// Texture coordinates from those of the mesh, whose v counts from the top.
    pub uv_from_mesh: Affine2,
    /// `-clamp on`.
    pub clamp: bool,
    /// `-bm`.
    pub strength: f32,
    /// `-imfchan`: a letter.
    pub channel: Option<char>,
    /// Options that were given and have no effect here.
    pub ignored: Vec<&'static str>,
}

/// Options with the most words that follow them. Those of `-s`, `-o` and `-t` are one to three numbers.
const OPTIONS: [(&str, usize); 13] = [
    ("-s", 3),
    ("-o", 3),
    ("-t", 3),
    ("-bm", 1),
    ("-clamp", 1),
    ("-imfchan", 1),
    ("-mm", 2),
    ("-boost", 1),
    ("-texres", 1),
    ("-blendu", 1),
    ("-blendv", 1),
    ("-cc", 1),
    ("-type", 1),
];

impl Map {
    /// A picture that lies on the surface as the mesh says.
    pub fn of(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            uv_from_mesh: Affine2::IDENTITY,
            clamp: false,
            strength: 1.0,
            channel: None,
            ignored: Vec::new(),
        }
    }

    /// Reads what follows the keyword. Options may stand on either side of the name, which may hold blanks.
    pub fn parse(rest: &str) -> Self {
        let words: Vec<Range<usize>> = text::words(rest).collect();
        let word = |index: usize| words.get(index).map(|range| &rest[range.clone()]);
        let mut map = Self::of("");
        let (mut scale, mut offset) = (Vec2::ONE, Vec2::ZERO);
        let mut name: Option<Range<usize>> = None;
        let mut at = 0;
        while let Some(current) = word(at) {
            let known = OPTIONS.iter().find(|(option, _)| option.eq_ignore_ascii_case(current));
            let Some(&(option, most)) = known else {
                // All words between options are the name.
                let range = words[at].clone();
                name = Some(name.map_or(range.clone(), |name| name.start..range.end));
                at += 1;
                continue;
            };
            let numbers: Vec<f32> = (at + 1..=at + most)
                .map_while(|at| word(at).and_then(text::number))
                .map(|number| number as f32)
                .collect();
            let pair = |default: f32| {
                Vec2::new(
                    numbers.first().copied().unwrap_or(default),
                    numbers.get(1).copied().unwrap_or(default),
                )
            };
            let argument = word(at + 1).unwrap_or_default();
            match option {
                "-s" => scale = pair(1.0),
                "-o" => offset = pair(0.0),
                "-bm" => map.strength = numbers.first().copied().unwrap_or(1.0),
                "-clamp" => map.clamp = argument.eq_ignore_ascii_case("on"),
                "-imfchan" => map.channel = argument.chars().next().map(|letter| letter.to_ascii_lowercase()),
                "-t" if pair(0.0) != Vec2::ZERO => map.ignored.push(option),
                "-mm" if pair(0.0) != Vec2::Y => map.ignored.push(option),
                _ => {}
            }
            let takes_numbers = matches!(option, "-s" | "-o" | "-t" | "-bm" | "-mm" | "-boost" | "-texres");
            at += 1 + if takes_numbers { numbers.len() } else { most };
        }
        rest[name.unwrap_or_default()].clone_into(&mut map.name);
        // In the file v counts from the bottom: `s v + o` from there is `1 - (s (1 - v) + o)` from the top.
        let from_top = Vec2::new(offset.x, 1.0 - scale.y - offset.y);
        let uv_from_mesh = Affine2::from_scale_angle_translation(scale, 0.0, from_top);
        if uv_from_mesh.is_finite() {
            map.uv_from_mesh = uv_from_mesh;
        }
        map
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_stand_on_either_side_of_a_name_with_blanks() {
        for text in [
            "-s 3 2 1 -o 0.25 0.5 my tex.png",
            "my tex.png -o 0.25 0.5 0 -s 3 2",
            "-S 3 2 1 my tex.png -o 0.25 0.5",
        ] {
            let map = Map::parse(text);
            assert_eq!(map.name, "my tex.png", "{text}");
            // 3 u + 1/4 and 2 v + 1/2 from the bottom.
            let uv = map.uv_from_mesh.transform_point2(Vec2::new(0.5, 1.0 - 0.125));
            assert_eq!(uv, Vec2::new(1.75, 1.0 - 0.75), "{text}");
        }
    }

    #[test]
    fn words_that_are_no_options_are_the_name() {
        let name = |text| Map::parse(text).name;
        assert_eq!(name("a -x b.png"), "a -x b.png");
        assert_eq!(name("-blendu on -blendv off -cc on -texres 512 -boost 2 -mm 0 1 a#b.png"), "a#b.png");
        assert_eq!(name("-bm a.png"), "a.png");
        assert_eq!(name(""), "");
        assert_eq!(name("-s 1 1 1"), "");
        let map = Map::parse("-imfchan M -clamp ON -bm 0.5 -t 1 0 0 -mm 0.1 1 \"a.png\"");
        assert_eq!(
            (map.name.as_str(), map.clamp, map.strength, map.channel),
            ("\"a.png\"", true, 0.5, Some('m'))
        );
        assert_eq!(map.ignored, ["-t", "-mm"]);
        assert_eq!(Map::parse("-s nan 1 a.png").uv_from_mesh, Affine2::IDENTITY);
    }
}
