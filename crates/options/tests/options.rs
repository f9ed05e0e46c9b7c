//! Settings that are declared once: by text, by table, by parts.
#![allow(missing_docs, clippy::unwrap_used)]

use gnomon_options::{
    Given, Group, OptionValue, Options, angle, any_number, choice, choices, color, file, markdown, number,
    power_of_two, settings, size, specs, text, whole, yes_no,
};

static KITCHEN: Group = Group { table: "", heading: "Kitchen", condition: None };
static SOUP: Group = Group { table: "soup", heading: "Soup", condition: Some(("pot", &["clay"])) };

choices! {
    /// What it is cooked in.
    pub enum Pot {
        /// An iron one.
        Iron = "iron",
        /// A clay one.
        Clay = "clay",
    }
}

settings! {
    /// How soup is cooked.
    pub struct SoupSettings in SOUP {
        /// Leeks in it.
        leeks: u32 = 3, whole(0, 12).alias("leeks");
        /// Time on the fire, without that of
        /// the bread.
        time: f32 = 0.1, number(0.0, 24.0).unit("h");
    }
}

settings! {
    /// How a kitchen works.
    pub struct KitchenSettings in KITCHEN {
        /// What soup is cooked in.
        pot: Pot = Pot::Iron, choice(Pot::choices);
        /// Plates on a pile.
        plates: usize = 8, power_of_two(1, 64);
        /// Guests that are known of.
        guests: Option<u32> = None, whole(1, 100).automatic("as many as come", 4.0).excludes("seats");
        /// Seats at the table.
        seats: Option<u32> = None, whole(1, 100).automatic("as many as come", 4.0).excludes("guests");
        /// Whether the door is open.
        open: bool = true, yes_no();
        /// Its floor.
        floor: [u32; 2] = [4, 3], size();
    } with {
        /// The soup.
        soup: SoupSettings;
    }
}

settings! {
    /// Who cooks.
    pub struct CookSettings in KITCHEN {
        /// Name of the cook.
        name: Option<String> = None, text().automatic("whoever is there", 0.0);
        /// Balance of the kitchen.
        balance: f32 = 0.0, any_number("EUR");
        /// Where the cook looks.
        view: f32 = 0.0, angle();
        /// Where the cook's recipes are.
        book: Option<String> = None, file().automatic("in mind", 0.0);
        /// What the cook wears.
        apron: [f32; 3] = [1.0, 1.0, 1.0], color();
        /// What the cook likes best.
        pot: Pot = Pot::Iron, choice(Pot::choices).varies("iron for stews, clay for the rest");
    }
}

settings! {
    /// How a kitchen is measured.
    pub struct RulerSettings in KITCHEN {
        /// Length of the unit.
        unit: f32 = 1.0, number(1e-6, 1e6).unit("m").words(&[("m", 1.0), ("cm", 0.01)]);
    }
}

#[test]
fn words_may_stand_for_numbers() {
    let read = |text: &str| toml::from_str::<RulerSettings>(text);
    for (text, unit) in [("unit = \"cm\"", 0.01), ("unit = \"m\"", 1.0), ("unit = 2", 2.0)] {
        assert_eq!(read(text).unwrap().unit, unit, "{text}");
    }
    let spec = specs::<RulerSettings>()[0];
    assert_eq!(spec.parse(" cm "), Ok(OptionValue::Number(0.01)));
    let allowed = "it takes a number from 0.000001 to 1000000 m, or m, cm";
    let error = read("unit = \"mile\"").unwrap_err().to_string();
    assert!(error.contains(allowed), "{error}");
    let error = spec.parse("mile").unwrap_err().to_string();
    assert!(error.contains(allowed) && error.contains("`mile`"), "{error}");
    assert!(spec.parse("0").is_err());
}

#[test]
fn texts_and_numbers_without_bounds() {
    let settings: CookSettings = toml::from_str("name = \" Ann \"\nbalance = -1e30\nview = 720").unwrap();
    let expected =
        CookSettings { name: Some(" Ann ".into()), balance: -1e30, view: 720.0, ..Default::default() };
    assert_eq!(settings, expected);
    assert_eq!(toml::from_str::<CookSettings>(&toml::to_string(&expected).unwrap()).unwrap(), expected);
    for (text, message) in [
        ("name = 3", "`name` cannot be `3`: it takes a text, or automatic"),
        ("balance = inf", "`balance` cannot be `inf`: it takes a finite number [EUR]"),
        ("view = nan", "`view` cannot be `NaN`: it takes a finite angle in degrees"),
    ] {
        let error = toml::from_str::<CookSettings>(text).unwrap_err().to_string();
        assert!(error.contains(message), "{error}");
    }
    let specs = specs::<CookSettings>();
    assert_eq!(specs[0].parse(" 7 "), Ok(OptionValue::Name(" 7 ".into())), "a text is what it is");
    let line = specs[5].help_line(&OptionValue::Name("iron".into()));
    assert!(line.ends_with("[default: iron for stews, clay for the rest]"), "{line}");
    let text = markdown("", &CookSettings::default());
    assert!(text.starts_with("| key | value | default |") && text.contains("| whoever is there |"), "{text}");
}

#[test]
fn colors_are_three_numbers_or_one_and_files_are_seen_from_their_table() {
    let read = |text| toml::from_str::<CookSettings>(text).map_err(|error| error.to_string());
    for text in ["apron = [0.5, 0.5, 0.5]", "apron = 0.5"] {
        assert_eq!(read(text).unwrap().apron, [0.5; 3]);
    }
    let spec = specs::<CookSettings>()[4];
    assert_eq!(spec.parse("1/0.25/0"), Ok(OptionValue::Color([1.0, 0.25, 0.0])));
    assert_eq!(spec.parse("0.25"), Ok(OptionValue::Color([0.25; 3])));
    for text in ["1/2", "1/-1/0", "inf", "red", ""] {
        let error = spec.parse(text).unwrap_err().to_string();
        assert!(error.contains("one number or RED/GREEN/BLUE"), "{error}");
    }
    assert!(read("apron = [1, 2]").is_err() && read("apron = [1, 2, 3, 4]").is_err());
    let mut expected = CookSettings { apron: [0.1, 2.0, 1e-9], ..Default::default() };
    assert_eq!(read(&toml::to_string(&expected).unwrap()), Ok(expected.clone()));

    let given = Given::deserialize::<CookSettings, _>(
        toml::Deserializer::parse("book = 'a.txt'\nname = 'b'").unwrap(),
    );
    let mut settings = CookSettings::default();
    given.unwrap().map_files::<CookSettings>(|path| format!("shelf/{path}")).apply(&mut settings);
    (expected.book, expected.name, expected.apron) = (Some("shelf/a.txt".into()), Some("b".into()), [1.0; 3]);
    assert_eq!(settings, expected);
}

#[test]
fn keys_of_others_are_passed_over() {
    let read = |text| {
        let table = toml::Deserializer::parse(text).unwrap();
        Given::deserialize_beside::<KitchenSettings, _>(&["owner"], table).map_err(|error| error.to_string())
    };
    assert!(read("owner = [1, 2]\nopen = false").unwrap().has("open"));
    let error = read("owned = 1").unwrap_err();
    assert!(error.contains("expected one of `owner`, `pot`"), "{error}");
    assert!(read("[soup]\nowner = 3").is_err());
}

#[test]
fn choices_are_read_and_written_by_name() {
    assert_eq!(serde_json::to_string(&Pot::Clay).unwrap(), "\"clay\"");
    assert_eq!(serde_json::from_str::<Pot>("\"clay\"").unwrap(), Pot::Clay);
    let error = serde_json::from_str::<Pot>("\"tin\"").unwrap_err().to_string();
    assert!(error.contains("unknown variant `tin`, expected `iron` or `clay`"), "{error}");
}

fn spec(name: &str) -> &'static gnomon_options::OptionSpec {
    specs::<KitchenSettings>().into_iter().find(|spec| spec.name() == name).unwrap()
}

fn read(text: &str) -> Result<KitchenSettings, String> {
    toml::from_str(text).map_err(|error| error.to_string())
}

#[test]
fn names_and_words_follow_from_the_declaration() {
    let names: Vec<String> = specs::<KitchenSettings>().iter().map(|spec| spec.name()).collect();
    assert_eq!(names, ["pot", "plates", "guests", "seats", "open", "floor", "soup-leeks", "soup-time"]);
    let time = spec("soup-time");
    let line = time.help_line(&OptionValue::Number(0.1));
    assert_eq!(line, "Time on the fire, without that of the bread [a number from 0 to 24 h] [default: 0.1]");
    assert!(spec("pot").long_help(&OptionValue::Name("iron".into())).ends_with("\n- clay: A clay one."));
    assert_eq!((time.condition(), spec("pot").condition()), (Some(("pot", ["clay"].as_slice())), None));
    let text = markdown("kitchen", &KitchenSettings::default());
    assert!(text.contains("| `plates` | Plates on a pile. A power of two from 1 to 64. | `8` |"), "{text}");
    assert!(text.contains("\n| `[kitchen.soup]` | value | default |"), "{text}");
}

#[test]
fn a_table_is_laid_over_the_defaults() {
    let settings = read("pot = \"clay\"\nfloor = [9, 9]\n[soup]\ntime = 2").unwrap();
    let mut expected = KitchenSettings { pot: Pot::Clay, floor: [9, 9], ..Default::default() };
    expected.soup.time = 2.0;
    assert_eq!(settings, expected);
    assert_eq!(read("leeks = 5").unwrap().soup.leeks, 5);
    assert_eq!(read("guests = \"automatic\"").unwrap(), KitchenSettings::default());
}

#[test]
fn what_is_written_is_read_again() {
    let mut settings = KitchenSettings { guests: Some(7), open: false, ..Default::default() };
    settings.soup.time = 1.0 / 3.0;
    let text = toml::to_string(&settings).unwrap();
    assert_eq!(read(&text).unwrap(), settings);
    assert!(text.contains("time = 0.33333334\n"), "{text}");
    let json = serde_json::to_string(&settings).unwrap();
    assert_eq!(serde_json::from_str::<KitchenSettings>(&json).unwrap(), settings);
}

#[test]
fn a_wrong_value_is_told_in_one_line_with_what_is_allowed() {
    for (name, text, message) in [
        ("plates", "12", "plates cannot be `12`: it takes a power of two from 1 to 64"),
        ("soup-leeks", "13", "soup-leeks cannot be `13`: it takes a whole number from 0 to 12"),
        ("soup-leeks", "-1", "soup-leeks cannot be `-1`: it takes a whole number from 0 to 12"),
        ("soup-leeks", "1.5", "soup-leeks cannot be `1.5`: it takes a whole number from 0 to 12"),
        ("soup-time", "nan", "soup-time cannot be `NaN`: it takes a number from 0 to 24 h"),
        ("soup-time", "long\nago", "soup-time cannot be `long ago`: it takes a number from 0 to 24 h"),
        ("pot", "tin", "pot cannot be `tin`: it takes one of: iron, clay"),
        ("open", "ajar", "open cannot be `ajar`: it takes true or false"),
        ("floor", "4x0", "floor cannot be `4x0`: it takes WIDTHxHEIGHT in pixels, as in 640x480"),
        ("guests", "0", "guests cannot be `0`: it takes a whole number from 1 to 100, or automatic"),
        ("plates", "automatic", "plates cannot be `automatic`: it takes a power of two from 1 to 64"),
    ] {
        assert_eq!(spec(name).parse(text).unwrap_err().to_string(), message);
    }
    for (text, line, message) in [
        ("plates = 12", 1, "`plates` cannot be `12`: it takes a power of two from 1 to 64"),
        ("open = true\nplates = \"many\"", 2, "`plates` cannot be `many`"),
        ("open = 1", 1, "`open` cannot be `1`: it takes true or false"),
        ("open = true\n[soup]\nleeks = 13", 3, "`leeks` cannot be `13`"),
        ("guests = 3\nseats = 4", 2, "`guests` and `seats` exclude each other"),
        ("spoon = 3", 1, "unknown field `spoon`, expected one of `pot`, `plates`"),
        ("[soup]\nspoon = 3", 2, "unknown field `spoon`, expected one of `leeks`, `time`"),
        ("leeks = 3\n[soup]\nleeks = 3", 3, "`leeks` is given twice"),
    ] {
        let error = read(text).unwrap_err();
        assert!(error.contains(message) && error.contains(&format!("line {line},")), "{error}");
    }
    let mut settings = KitchenSettings::default();
    settings.soup.time = f32::NAN;
    let message = settings.check().unwrap_err().to_string();
    assert_eq!(message, "soup-time cannot be `NaN`: it takes a number from 0 to 24 h");
}

#[test]
fn what_is_given_goes_over_what_is_there() {
    let mut given = Given::default();
    given.parse(spec("seats"), "12").unwrap();
    given.parse(spec("soup-time"), "3").unwrap();
    let mut settings = KitchenSettings { guests: Some(7), plates: 16, ..Default::default() };
    given.apply(&mut settings);
    let mut expected = KitchenSettings { seats: Some(12), plates: 16, ..Default::default() };
    expected.soup.time = 3.0;
    assert_eq!(settings, expected, "guests go where seats are given");
    assert!(given.has("seats") && !given.has("plates"));

    let before = KitchenSettings::default();
    let after = KitchenSettings { open: false, ..before.clone() };
    let mut other = KitchenSettings { plates: 2, ..before.clone() };
    Given::changes(&before, &after).apply(&mut other);
    assert_eq!(other, KitchenSettings { plates: 2, open: false, ..before });
}
