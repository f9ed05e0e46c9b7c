//! The document of a glTF file, from its text as tools really write it: what has no meaning reads as absent.

use std::borrow::Cow;

use gnomon_messages::quoted;
use serde_json::Value;

use super::schema::Root;
use super::{Budget, Fault};

/// Bytes that a parsed object takes at least, and an element or member more: `serde_json` keeps members in a B-tree.
const OBJECT_BYTES: usize = 600;
const ELEMENT_BYTES: usize = 100;

/// Parses the document.
///
/// Members that are null are absent, and so are null entries in lists of children; other null entries of lists of objects are empty
/// objects, since others are counted past them. Of members of one name the last counts. Bytes that are no Unicode, and halves of surrogate
/// pairs, stand for a replacement character: they are in names.
pub fn parse(json: &[u8], budget: &mut Budget, warnings: &mut Vec<String>) -> Result<Root, Fault> {
    let json = crate::without_bom(json);
    // A GLB is padded with blanks, and by some writers with zeros.
    let end = json.iter().rposition(|byte| *byte != 0).map_or(0, |last| last + 1);
    let text = unicode(&json[..end]);
    if let Cow::Owned(_) = text {
        warnings.push("text that is no Unicode is shown with replacement characters".to_owned());
    }
    let count = |sought: &[u8]| text.bytes().filter(|byte| sought.contains(byte)).count();
    let (objects, elements) = (count(b"{"), count(b",["));
    budget.take(text.len(), 4)?;
    budget.take(objects, OBJECT_BYTES)?;
    budget.take(elements, ELEMENT_BYTES)?;
    let mut document: Value = serde_json::from_str(&text).map_err(|error| {
        let hint = if is_at_no_number(&text, &error) { " (JSON has no NaN and no infinity)" } else { "" };
        Fault::Invalid(format!("the document is no JSON: {error}{hint}"))
    })?;
    check_version(&document)?;
    tidy(&mut document);
    let root = serde_path_to_error::deserialize(document).map_err(|error| {
        let path = error.path().to_string();
        Fault::Invalid(format!("the document does not follow glTF: {path}: {}", error.into_inner()))
    })?;
    budget.give_back(objects, OBJECT_BYTES);
    budget.give_back(elements, ELEMENT_BYTES);
    Ok(root)
}

/// The text with replacement characters for what no Unicode text can hold.
fn unicode(bytes: &[u8]) -> Cow<'_, str> {
    let text = String::from_utf8_lossy(bytes);
    match without_lone_surrogates(&text) {
        Some(repaired) => Cow::Owned(repaired),
        None => text,
    }
}

/// The text with `\ufffd` for every escaped half of a pair that stands alone; `None` where there is none.
fn without_lone_surrogates(text: &str) -> Option<String> {
    let code = |at: usize| {
        let digits = text.get(at..)?.strip_prefix("\\u")?.get(..4)?;
        u32::from_str_radix(digits, 16).ok()
    };
    let mut alone = Vec::new();
    let mut at = 0;
    while let Some(next) = text[at..].find('\\') {
        at += next;
        let is_high = |code: &u32| (0xd800..0xdc00).contains(code);
        let is_low = |code: &u32| (0xdc00..0xe000).contains(code);
        let (high, low) = (code(at).filter(is_high), code(at + 6).filter(is_low));
        at += match (high, low) {
            (Some(_), Some(_)) => 12,
            (Some(_), None) => {
                alone.push(at);
                6
            }
            _ if code(at).is_some_and(|code| is_low(&code)) => {
                alone.push(at);
                6
            }
            // Whatever follows is no beginning of another escape; it may be a character of several bytes.
            _ => 1 + text[at + 1..].chars().next().map_or(0, char::len_utf8),
        };
    }
    let mut repaired = (!alone.is_empty()).then(|| text.to_owned())?;
    for at in alone {
        repaired.replace_range(at..at + 6, "\\ufffd");
    }
    Some(repaired)
}

/// Whether the parser stopped at a word for what is no number.
fn is_at_no_number(text: &str, error: &serde_json::Error) -> bool {
    let lines = text.split_inclusive('\n').take(error.line().saturating_sub(1));
    let at = lines.map(str::len).sum::<usize>() + error.column().saturating_sub(1);
    // The column is that of its first letter, or of the first that no word of JSON has.
    let near = text.as_bytes().get(at.saturating_sub(2)..).unwrap_or_default();
    let near = near[..near.len().min(6)].to_ascii_lowercase();
    near.windows(3).any(|word| word == b"nan" || word == b"inf")
}

fn check_version(document: &Value) -> Result<(), Fault> {
    let version_of = |value: &Value| match value {
        Value::String(text) => Some(text.clone()),
        Value::Number(number) => Some(number.to_string()),
        _ => None,
    };
    let parse = |text: &str| -> Result<(u32, u32), Fault> {
        let (major, minor) = text.split_once('.').unwrap_or((text, "0"));
        let parts = major.parse().ok().zip(minor.parse().ok());
        parts.ok_or_else(|| Fault::Invalid(format!("'{}' is no glTF version", quoted(text))))
    };
    let asset = &document["asset"];
    let version = version_of(&asset["version"]);
    // What 2.0 lists, 1.0 has by name; its first files do not say which version they are.
    if ["nodes", "meshes", "accessors", "buffers"].iter().any(|key| document[key].is_object()) {
        return Err(first_version(version.as_deref().unwrap_or("1.0")));
    }
    let Some(version) = version else {
        return Err(Fault::invalid("asset.version is missing, which tells what version of glTF it is"));
    };
    match parse(&version)? {
        (2, _) => {}
        (0 | 1, _) => return Err(first_version(&version)),
        (major, minor) => {
            return Err(Fault::Unsupported(format!("glTF version {major}.{minor} (2.0 is known)")));
        }
    }
    if let Some(least) = version_of(&asset["minVersion"]) {
        let least = parse(&least)?;
        if least > (2, 0) {
            return Err(Fault::Unsupported(format!("it needs glTF {}.{} (2.0 is known)", least.0, least.1)));
        }
    }
    Ok(())
}

/// What to say of a file of a version before 2.0.
pub fn first_version(version: &str) -> Fault {
    Fault::Unsupported(format!(
        "this is glTF version {} (2.0 is known): convert it to 2.0, for instance with gltf-pipeline",
        quoted(version)
    ))
}

/// Takes out what is null.
fn tidy(document: &mut Value) {
    let Value::Object(members) = document else { return };
    members.retain(|_, value| !value.is_null());
    for (key, value) in members {
        // Of extensions' names there is a list at the top, too.
        if let (Value::Array(items), false) = (&mut *value, key.starts_with("extensions")) {
            items.iter_mut().filter(|item| item.is_null()).for_each(make_empty);
        }
        tidy_member(key, value);
    }
}

fn tidy_member(key: &str, value: &mut Value) {
    match value {
        Value::Object(members) => {
            members.retain(|_, value| !value.is_null());
            members.iter_mut().for_each(|(key, value)| tidy_member(key, value));
        }
        Value::Array(items) => {
            if items.iter().any(Value::is_object) {
                items.iter_mut().filter(|item| item.is_null()).for_each(make_empty);
            } else if ["children", "nodes"].contains(&key) || key.starts_with("extensions") {
                items.retain(|item| !item.is_null());
            }
            items.iter_mut().for_each(|item| tidy_member("", item));
        }
        _ => {}
    }
}

fn make_empty(value: &mut Value) {
    *value = Value::Object(serde_json::Map::new());
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn halves_of_surrogate_pairs_are_replaced_and_pairs_stay() {
        for (text, repaired) in [
            (r"a\ud800b", Some(r"a\ufffdb")),
            (r"\udc00\ud800", Some(r"\ufffd\ufffd")),
            (r"\ud83d\ude00\ud83d", Some(r"\ud83d\ude00\ufffd")),
            // An escaped backslash before letters that look like an escape.
            (r"\\ud800", None),
            (r"\\\ud800", Some(r"\\\ufffd")),
            ("\\é\\ud8", None),
            ("\\", None),
        ] {
            assert_eq!(without_lone_surrogates(text).as_deref(), repaired, "{text}");
        }
    }

    #[test]
    fn null_is_absent_and_empty_where_others_are_counted_past_it() {
        let mut document = json!({
            "nodes": [null, {"children": [null, 0, null], "matrix": null}], "meshes": [null],
            "scenes": [{"nodes": [1, null]}], "extensionsUsed": [null, "A"], "skins": null,
            "materials": [{"emissiveFactor": [null, 0, 0]}]
        });
        tidy(&mut document);
        assert_eq!(
            document,
            json!({
                "nodes": [{}, {"children": [0]}], "meshes": [{}], "scenes": [{"nodes": [1]}], "extensionsUsed": ["A"],
                "materials": [{"emissiveFactor": [null, 0, 0]}]
            })
        );
    }

    #[test]
    fn words_for_no_number_are_told() {
        for text in ["[NaN, 0]", "[0, -Infinity]", "{\n\"a\": nan}", "[0,\n-NaN,1]"] {
            let error = serde_json::from_str::<Value>(text).unwrap_err();
            assert!(is_at_no_number(text, &error), "{text}: {error}");
        }
        let error = serde_json::from_str::<Value>("[0, x]").unwrap_err();
        assert!(!is_at_no_number("[0, x]", &error));
    }
}
