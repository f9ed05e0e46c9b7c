//! OpenEXR files: those of other programs, damaged ones, and our own.
#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests fail as tests do")]

use std::path::PathBuf;

use glam::Vec3;
use gnomon_picture::{
    DecodeError, EnvironmentAttribute, RgbImage, TexelSink, decode, decode_into, exr, read,
};
use gnomon_testing::data_file;
use proptest::prelude::*;

fn files(folder: &str) -> Vec<PathBuf> {
    let Some(folder) = data_file(folder) else { return Vec::new() };
    let mut files: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files
}

/// Most memory that this process ever held [bytes], where the system tells.
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    Some(line.split_ascii_whitespace().nth(1)?.parse::<u64>().ok()? * 1024)
}

#[test]
fn every_damaged_file_ends_in_a_picture_or_one_line_of_error() {
    let mut opened = 0;
    for path in files("bad_inputs/exr") {
        let started = std::time::Instant::now();
        if let Err(error) = read(&path) {
            assert_eq!(error.to_string().lines().count(), 1, "{error}");
        }
        assert!(started.elapsed().as_secs() < 10, "{}", path.display());
        opened += 1;
    }
    assert!(opened == 0 || opened > 90, "{opened}");
    assert!(peak_memory().is_none_or(|bytes| bytes < 2 << 30));
}

#[test]
fn every_environment_of_the_test_data_is_read() {
    for path in files("env").iter().filter(|path| path.extension().is_some_and(|e| e == "exr")) {
        let decoded = read(path).unwrap_or_else(|error| panic!("{error}"));
        let name = path.file_name().unwrap().to_string_lossy();
        let expected = match name.as_ref() {
            "openexr_KernerEnvCube.exr" => Some((256, 1536, EnvironmentAttribute::Cube)),
            "openexr_OrientationCube.exr" => Some((512, 3072, EnvironmentAttribute::Cube)),
            "openexr_OrientationLatLong.exr" => Some((1024, 512, EnvironmentAttribute::LatLong)),
            _ => continue,
        };
        let found = decoded.environment.map(|kind| (decoded.image.width(), decoded.image.height(), kind));
        assert_eq!(found, expected, "{name}");
    }
}

#[test]
fn dwab_matches_its_photograph() {
    let Some(path) = data_file("env/cc0_pmndrs_sky_dwab.exr") else { return };
    let image = read(path).unwrap().image;
    assert_eq!((image.width(), image.height()), (512, 256));
    let mean = |rows: std::ops::Range<u32>| {
        let count = rows.len() as f32 * image.width() as f32;
        rows.flat_map(|y| (0..image.width()).map(move |x| (x, y))).map(|(x, y)| image.get(x, y)).sum::<Vec3>()
            / count
    };
    // A sky: blue above, and brighter than the ground.
    let (above, below) = (mean(0..100), mean(160..256));
    assert!(above.is_finite() && above.z > above.x && above.y > below.y, "{above} {below}");
}

#[test]
fn nan_and_infinity_arrive_as_they_are() {
    let Some(path) = data_file("env/openexr_BrightRingsNanInf.exr") else { return };
    let image = read(path).unwrap().image;
    let channels = || image.texels().iter().flat_map(|texel| texel.to_array());
    assert!(channels().any(f32::is_nan) && channels().any(f32::is_infinite));
    let Some(path) = data_file("env/openexr_AllHalfValues.exr") else { return };
    // 65,536 codes of a half: 2 x 1023 NaN and 2 infinities for each channel.
    let image = read(path).unwrap().image;
    assert_eq!(image.texels().len(), 65_536);
    assert_eq!(image.texels().iter().filter(|texel| texel.x.is_nan()).count(), 2046);
    assert_eq!(image.texels().iter().filter(|texel| texel.x.is_infinite()).count(), 2);
}

#[test]
fn the_reference_renders_have_their_published_mean() {
    let Some(json) = data_file("reference/renders.json") else { return };
    let text = std::fs::read_to_string(&json).unwrap();
    for (name, mean) in [
        ("three_boxes_grace.exr", [1.2971, 0.95239, 1.51361]),
        ("bunny_flat_stpeters.exr", [0.60753, 0.42896, 0.36131]),
    ] {
        assert!(text.contains(name));
        let image = read(json.with_file_name(name)).unwrap().image;
        let ours = image.texels().iter().sum::<Vec3>() / image.texels().len() as f32;
        assert!((ours / Vec3::from_array(mean) - 1.0).abs().max_element() < 1e-3, "{name}: {ours}");
    }
}

/// A file with channels and windows of our choice.
fn with_channels(names: &[&str], offset: i32, display: (usize, usize)) -> Vec<u8> {
    use ::exr::prelude::*;
    let size = (4, 2);
    let channel = |(index, name): (usize, &&str)| {
        let values = (0..8).map(|i| (10 * index + i) as f32).collect();
        AnyChannel::new(*name, FlatSamples::F32(values))
    };
    let channels = AnyChannels::sort(names.iter().enumerate().map(channel).collect());
    let attributes = LayerAttributes::named("layer").with_position(Vec2(offset, 0));
    let layer = Layer::new(size, attributes, Encoding::UNCOMPRESSED, channels);
    let window = IntegerBounds::from_dimensions(Vec2(display.0, display.1));
    let image = Image::empty(ImageAttributes::new(window)).with_layer(layer);
    let mut bytes = std::io::Cursor::new(Vec::new());
    image.write().to_buffered(&mut bytes).unwrap();
    bytes.into_inner()
}

/// A file of several parts, each with a name and channels; sample `i` of channel `n` of part `p` is `100 p + 10 n + i`.
fn with_parts(parts: &[(&str, &[&str])]) -> Vec<u8> {
    use ::exr::prelude::*;
    let layer = |(part, (name, channels)): (usize, &(&str, &[&str]))| {
        let channel = |(index, name): (usize, &&str)| {
            let values = (0..8).map(|i| (100 * part + 10 * index + i) as f32).collect();
            AnyChannel::new(*name, FlatSamples::F32(values))
        };
        let channels = AnyChannels::sort(channels.iter().enumerate().map(channel).collect());
        Layer::new((4, 2), LayerAttributes::named(*name), Encoding::UNCOMPRESSED, channels)
    };
    let layers: Vec<_> = parts.iter().enumerate().map(layer).collect();
    let attributes = ImageAttributes::new(IntegerBounds::from_dimensions(Vec2(4, 2)));
    let mut bytes = std::io::Cursor::new(Vec::new());
    Image::from_layers(attributes, layers).write().to_buffered(&mut bytes).unwrap();
    bytes.into_inner()
}

/// First texel and warnings, or the error.
fn first_texel(bytes: &[u8], layer: Option<&str>) -> Result<([f32; 3], usize), String> {
    struct First([f32; 3]);
    impl TexelSink for First {
        fn begin(&mut self, _: u32, _: u32, _: Option<EnvironmentAttribute>) {}
        fn texels(&mut self, x: u32, y: u32, texels: &[Vec3]) {
            if (x, y) == (0, 0) {
                self.0 = texels[0].to_array();
            }
        }
    }
    let mut first = First([f32::NAN; 3]);
    let description = decode_into(bytes, layer, &mut first).map_err(|error| error.to_string())?;
    Ok((first.0, description.warnings.len()))
}

#[test]
fn the_layer_that_is_plainly_the_picture_is_found() {
    let plain = |channels: &[&str]| first_texel(&with_channels(channels, 0, (4, 2)), None);
    let found =
        |r: usize, g: usize, b: usize, warnings: usize| Ok(([r, g, b].map(|n| 10.0 * n as f32), warnings));
    assert_eq!(plain(&["A", "B", "G", "R"]), found(3, 2, 1, 0));
    assert_eq!(plain(&["a", "b", "g", "r"]), found(3, 2, 1, 0));
    assert_eq!(plain(&["Blue", "GREEN", "red"]), found(2, 1, 0, 0));
    assert_eq!(
        plain(&[
            "View Layer.Combined.A",
            "View Layer.Combined.B",
            "View Layer.Combined.G",
            "View Layer.Combined.R"
        ]),
        found(3, 2, 1, 0)
    );
    // With others beside it.
    assert_eq!(plain(&["B", "G", "R", "diffuse.B", "diffuse.G", "diffuse.R"]), found(2, 1, 0, 0));
    assert_eq!(
        plain(&[
            "L.Combined.B",
            "L.Combined.G",
            "L.Combined.R",
            "L.Diff.B",
            "L.Diff.G",
            "L.Diff.R",
            "L.Depth.Z"
        ]),
        found(2, 1, 0, 0)
    );
    // The compositor's picture before what it is made of.
    assert_eq!(
        plain(&[
            "Composite.Combined.B",
            "Composite.Combined.G",
            "Composite.Combined.R",
            "L.Combined.B",
            "L.Combined.G",
            "L.Combined.R"
        ]),
        found(2, 1, 0, 0)
    );
    // Luminance, and the only channel, are grey, which is said.
    assert_eq!(plain(&["Y"]), found(0, 0, 0, 1));
    assert_eq!(plain(&["A", "Y", "Z"]), found(1, 1, 1, 1));
    assert_eq!(plain(&["depth"]), found(0, 0, 0, 1));
}

#[test]
fn where_no_layer_is_plainly_the_picture_those_there_are_told() {
    let plain = |channels: &[&str]| first_texel(&with_channels(channels, 0, (4, 2)), None).unwrap_err();
    let lit = ["diffuse.B", "diffuse.G", "diffuse.R", "glossy.B", "glossy.G", "glossy.R"];
    let error = plain(&lit);
    assert!(error.contains("diffuse, glossy") && error.contains("--env-layer"), "{error}");
    let error = plain(&["A", "Z"]);
    assert!(error.contains("A, Z"), "{error}");
    assert!(plain(&["G", "R"]).contains("G, R"));
    // Two view layers.
    let two = [
        "V1.Combined.B",
        "V1.Combined.G",
        "V1.Combined.R",
        "V2.Combined.B",
        "V2.Combined.G",
        "V2.Combined.R",
    ];
    assert!(plain(&two).contains("V1.Combined, V2.Combined"));

    let named = |channels: &[&str], name| first_texel(&with_channels(channels, 0, (4, 2)), Some(name));
    assert_eq!(named(&lit, "Glossy"), Ok(([50.0, 40.0, 30.0], 0)));
    assert_eq!(named(&two, "V2.Combined"), Ok(([50.0, 40.0, 30.0], 0)));
    assert_eq!(named(&["A", "Z"], "Z"), Ok(([10.0; 3], 1)));
    assert_eq!(named(&["B", "G", "L.Depth.Z", "R"], "L.Depth"), Ok(([20.0; 3], 1)));
    let error = named(&lit, "nothing\nhere").unwrap_err();
    assert!(error.contains("diffuse, glossy") && error.lines().count() == 1, "{error}");
    assert!(first_texel(b"#?RADIANCE", Some("x")).unwrap_err().contains("Radiance"));
}

#[test]
fn of_several_parts_the_one_with_colours_is_read() {
    let rgb: &[&str] = &["B", "G", "R"];
    let depth_first = with_parts(&[("depth", &["Z"]), ("picture", rgb)]);
    assert_eq!(first_texel(&depth_first, None), Ok(([120.0, 110.0, 100.0], 0)));
    let two = with_parts(&[("left", rgb), ("right", rgb)]);
    assert_eq!(first_texel(&two, None), Ok(([20.0, 10.0, 0.0], 1)));
    assert_eq!(first_texel(&two, Some("right")), Ok(([120.0, 110.0, 100.0], 0)));
    let combined: &[&str] = &["L.Combined.B", "L.Combined.G", "L.Combined.R"];
    let blender = with_parts(&[("L.Diffuse", rgb), ("L.Combined", combined)]);
    assert_eq!(first_texel(&blender, None), Ok(([120.0, 110.0, 100.0], 0)));
    assert_eq!(first_texel(&depth_first, Some("depth.Z")), Ok(([0.0; 3], 1)));
}

#[test]
fn a_cropped_picture_lies_where_its_windows_say() {
    let image = decode(&with_channels(&["Y"], 1, (6, 3))).unwrap().image;
    let row = |y: u32| (0..6).map(|x| image.get(x, y).x).collect::<Vec<_>>();
    assert_eq!((image.width(), image.height()), (6, 3));
    assert_eq!(row(0), [0.0, 0.0, 1.0, 2.0, 3.0, 0.0]);
    assert_eq!(row(2), [0.0; 6]);
    // A data window larger than the display window is cut.
    let image = decode(&with_channels(&["Y"], -1, (2, 1))).unwrap().image;
    assert_eq!((image.get(0, 0).x, image.get(1, 0).x), (1.0, 2.0));
}

#[test]
fn a_header_that_claims_too_much_is_refused() {
    let sound = exr::encode(&RgbImage::filled(4, 2, Vec3::ONE)).unwrap();
    let at =
        sound.windows(10).position(|bytes| bytes == b"dataWindow").unwrap() + "dataWindow\0box2i\0".len() + 4;
    // More than the limit; and more than a file of this length can hold.
    for width in [100_000_000i32, 100_000] {
        let mut bytes = sound.clone();
        bytes[at + 8..at + 12].copy_from_slice(&width.to_le_bytes());
        let outcome = decode(&bytes);
        assert!(matches!(outcome, Err(DecodeError::TooLarge { .. })), "{:?}", outcome.err());
    }
    assert!(decode(&sound).is_ok());
    assert!(exr::encode(&RgbImage::filled(0, 2, Vec3::ONE)).is_err());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn writing_loses_nothing(width in 1u32..40, height in 1u32..40, bits in any::<[u32; 7]>()) {
        let texel = |x: u32, y: u32| {
            let value = |k: u32| f32::from_bits(bits[((x + 3 * y + k) % 7) as usize].rotate_left(x));
            Vec3::new(value(0), value(1), value(2))
        };
        let image = RgbImage::from_fn(width, height, texel);
        let back = decode(&exr::encode(&image).unwrap()).unwrap().image;
        let bits = |image: &RgbImage| -> Vec<[u32; 3]> {
            image.texels().iter().map(|texel| texel.to_array().map(f32::to_bits)).collect()
        };
        prop_assert_eq!(bits(&back), bits(&image));
    }
}

/// Small pictures in every compression, of halves and floats, in scanlines and tiles.
fn every_compression() -> Vec<Vec<u8>> {
    use ::exr::prelude::*;
    let methods = [
        Compression::Uncompressed,
        Compression::RLE,
        Compression::ZIP1,
        Compression::ZIP16,
        Compression::PIZ,
        Compression::PXR24,
        Compression::B44,
        Compression::B44A,
        Compression::DWAA(None),
        Compression::DWAB(None),
    ];
    let mut files = Vec::new();
    for (compression, half, tiles) in
        methods.into_iter().flat_map(|method| [(false, false), (true, true)].map(|(a, b)| (method, a, b)))
    {
        let value = move |seed: usize, i: usize| ((i * (seed + 1)) % 97) as f32 * 0.37 + (i / 60) as f32;
        let samples = |seed: usize| match half {
            true => FlatSamples::F16((0..60 * 44).map(|i| f16::from_f32(value(seed, i))).collect()),
            false => FlatSamples::F32((0..60 * 44).map(|i| value(seed, i)).collect()),
        };
        let channels = ["B", "G", "R"].iter().enumerate().map(|(i, name)| AnyChannel::new(*name, samples(i)));
        let blocks = if tiles { Blocks::Tiles(Vec2(16, 16)) } else { Blocks::ScanLines };
        let encoding = Encoding { compression, blocks, line_order: LineOrder::Increasing };
        let channels = AnyChannels::sort(channels.collect());
        let layer = Layer::new((60, 44), LayerAttributes::default(), encoding, channels);
        let mut bytes = std::io::Cursor::new(Vec::new());
        Image::from_layer(layer).write().to_buffered(&mut bytes).unwrap();
        files.push(bytes.into_inner());
    }
    files
}

#[test]
fn no_damage_panics_or_allocates_without_bound() {
    for sound in every_compression() {
        let image = decode(&sound).unwrap().image;
        // Red at (2, 1): sample 62 of the third channel; lossy methods keep it within some percent.
        let expected = ((62 * 3) % 97) as f32 * 0.37 + 1.0;
        assert!((image.get(2, 1).x - expected).abs() < 0.15 * expected, "{}", image.get(2, 1));
        let mut state = 0x9e37_79b9_7f4a_7c15_u64;
        let mut random = |end: usize| {
            // Marsaglia 2003, xorshift64.
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state % end as u64) as usize
        };
        for _ in 0..150 {
            let mut bytes = sound.clone();
            for _ in 0..=random(3) {
                let at = random(bytes.len());
                bytes[at] = random(256) as u8;
            }
            if random(8) == 0 {
                bytes.truncate(random(sound.len()));
            }
            if let Err(error) = decode(&bytes) {
                assert_eq!(error.to_string().lines().count(), 1, "{error}");
            }
        }
    }
    assert!(peak_memory().is_none_or(|bytes| bytes < 2 << 30));
}

/// 4 x 4 texels of luminance 1 to 16 and chroma of every second texel across and down, uncompressed, as the format's specification has it.
fn luminance_chroma(ry: f32, by: f32) -> Vec<u8> {
    let mut bytes = vec![0x76, 0x2f, 0x31, 0x01, 2, 0, 0, 0];
    let attribute = |bytes: &mut Vec<u8>, name: &str, kind: &str, value: &[u8]| {
        bytes.extend(name.bytes().chain([0]).chain(kind.bytes()).chain([0]));
        bytes.extend((value.len() as i32).to_le_bytes());
        bytes.extend(value);
    };
    let numbers = |numbers: &[i32]| numbers.iter().flat_map(|n| n.to_le_bytes()).collect::<Vec<u8>>();
    let floats = |floats: &[f32]| floats.iter().flat_map(|n| n.to_le_bytes()).collect::<Vec<u8>>();
    let mut channels = Vec::new();
    for (name, step) in [("BY", 2), ("RY", 2), ("Y", 1)] {
        channels.extend(name.bytes().chain([0]));
        channels.extend(numbers(&[2, 0, step, step]));
    }
    channels.push(0);
    attribute(&mut bytes, "channels", "chlist", &channels);
    attribute(&mut bytes, "compression", "compression", &[0]);
    attribute(&mut bytes, "dataWindow", "box2i", &numbers(&[0, 0, 3, 3]));
    attribute(&mut bytes, "displayWindow", "box2i", &numbers(&[0, 0, 3, 3]));
    attribute(&mut bytes, "lineOrder", "lineOrder", &[0]);
    attribute(&mut bytes, "pixelAspectRatio", "float", &floats(&[1.0]));
    attribute(&mut bytes, "screenWindowCenter", "v2f", &floats(&[0.0, 0.0]));
    attribute(&mut bytes, "screenWindowWidth", "float", &floats(&[1.0]));
    bytes.push(0);
    let row = |y: i32| {
        let chroma = if y % 2 == 0 { floats(&[by, by, ry, ry]) } else { Vec::new() };
        let luminance: Vec<f32> = (1..=4).map(|x| (4 * y + x) as f32).collect();
        let data = [chroma, floats(&luminance)].concat();
        [numbers(&[y, data.len() as i32]), data].concat()
    };
    let mut at = bytes.len() + 4 * 8;
    for y in 0..4 {
        bytes.extend((at as u64).to_le_bytes());
        at += row(y).len();
    }
    (0..4).for_each(|y| bytes.extend(row(y)));
    bytes
}

#[test]
fn chroma_of_every_second_texel_becomes_colour() {
    let image = decode(&luminance_chroma(0.5, -0.25)).unwrap().image;
    for (y, x) in (0..4).flat_map(|y| (0..4).map(move |x| (y, x))) {
        let luminance = (4 * y + x + 1) as f32;
        let (r, b) = (1.5 * luminance, 0.75 * luminance);
        let g = (luminance - 0.2126 * r - 0.0722 * b) / 0.7152;
        // The filter's weights sum to 1 within 2e-5.
        let off = (image.get(x, y) - Vec3::new(r, g, b)).abs().max_element();
        assert!(off < 1e-4 * luminance, "{x} {y}: {}", image.get(x, y));
    }
    // Without chroma exactly grey.
    assert_eq!(decode(&luminance_chroma(0.0, 0.0)).unwrap().image.get(3, 3), Vec3::splat(16.0));
    // Cut off anywhere, an error.
    let bytes = luminance_chroma(0.5, -0.25);
    (0..bytes.len()).for_each(|length| assert!(decode(&bytes[..length]).is_err(), "{length}"));
}

#[test]
fn channels_of_any_name_lie_beside_the_picture() {
    use gnomon_picture::exr::{Channel, Samples, encode_channels};
    let channel = |name: &str, samples| Channel { name: name.to_owned(), samples };
    let floats = |first: f32| Samples::Floats((0..6).map(|i| first + i as f32).collect());
    let depth = Samples::Floats(vec![1.0, f32::INFINITY, -0.0, f32::NAN, 5.0, 6.0]);
    let channels = || {
        vec![
            channel("R", floats(0.0)),
            channel("Z", depth.clone()),
            channel("G", floats(10.0)),
            channel("object.X", Samples::Labels(vec![u32::MAX, 0, 16_777_217, 3, 4, 5])),
            channel("B", floats(20.0)),
            channel("diffuse.R", floats(30.0)),
            channel("diffuse.G", floats(40.0)),
            channel("diffuse.B", floats(50.0)),
        ]
    };
    let attributes = [("gnomon.depth".to_owned(), "metres".to_owned())];
    let bytes = encode_channels([3, 2], channels(), &attributes).unwrap();
    let image = decode(&bytes).unwrap().image;
    assert_eq!((image.width(), image.get(1, 1)), (3, Vec3::new(4.0, 14.0, 24.0)));
    assert_eq!(first_texel(&bytes, Some("diffuse")).unwrap(), ([30.0, 40.0, 50.0], 0));
    let twice = [channels(), vec![channel("Z", floats(0.0))]].concat();
    assert!(encode_channels([3, 2], twice, &[]).unwrap_err().contains("two channels"));
    assert!(encode_channels([2, 2], channels(), &[]).unwrap_err().contains("texels"));
    assert!(encode_channels([0, 2], Vec::new(), &[]).is_err());
}
