//! What URIs in glTF files stand for: embedded data, or a file relative to this one.

use base64::Engine;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use gnomon_messages::quoted;

use super::{Budget, Fault, Source};
use crate::SceneFileError;

/// Bytes behind a URI.
///
/// A file is looked for by its percent-decoded name, by the name as it stands (tools forget to encode), and by both with `/` for the `\` of
/// Windows. Names may begin with blanks.
pub fn resolve(uri: &str, source: &Source, budget: &mut Budget) -> Result<Vec<u8>, Fault> {
    if let Some(data) = strip_scheme(uri.trim(), "data") {
        return embedded(data, budget);
    }
    let relative = |path: &str| !path.starts_with(['/', '\\']) && scheme(path).is_none();
    let address = || match scheme(uri) {
        Some(scheme) if scheme.to_ascii_lowercase().starts_with("http") => "is a web address, not",
        _ => "is not",
    };
    let elsewhere =
        || Fault::Unsupported(format!("'{}' {} a path relative to the file", quoted(uri), address()));
    let decoded = String::from_utf8(percent_decoded(uri)).ok();
    let mut names: Vec<String> = Vec::new();
    for name in [decoded.as_deref(), Some(uri)].into_iter().flatten() {
        if !relative(name) {
            return Err(elsewhere());
        }
        for name in [name.to_owned(), name.replace('\\', "/")] {
            if !name.is_empty() && !name.contains('\0') && !names.contains(&name) {
                names.push(name);
            }
        }
    }
    let mut first = None;
    for name in names {
        let path = source.sibling(&name);
        match source.read(&path, budget) {
            // Not there: perhaps under another of its names.
            Err(Fault::Elsewhere(error @ SceneFileError::Io { .. })) => {
                first.get_or_insert(Fault::Elsewhere(error));
            }
            Err(fault) => return Err(Fault::Elsewhere(fault.at(&path))),
            Ok(bytes) => return Ok(bytes),
        }
    }
    Err(first.unwrap_or_else(|| Fault::Invalid(format!("'{}' is no URI", quoted(uri)))))
}

/// The scheme of a URI that has one. Windows' drives have one letter.
fn scheme(uri: &str) -> Option<&str> {
    let (scheme, _) = uri.split_once(':')?;
    let is_scheme = scheme.bytes().all(|b| b.is_ascii_alphanumeric() || b"+-.".contains(&b));
    (is_scheme && !scheme.is_empty()).then_some(scheme)
}

fn strip_scheme<'a>(uri: &'a str, wanted: &str) -> Option<&'a str> {
    let found = scheme(uri)?;
    found.eq_ignore_ascii_case(wanted).then(|| &uri[found.len() + 1..])
}

/// Bytes of a data URI behind its scheme (RFC 2397): base64 with blanks and line breaks in it, in either alphabet, or percent-encoded.
fn embedded(data: &str, budget: &mut Budget) -> Result<Vec<u8>, Fault> {
    let (kind, text) = data.split_once(',').ok_or_else(|| Fault::invalid("a data URI has no data"))?;
    budget.take(text.len(), 1)?;
    let is_base64 = kind.rsplit(';').next().is_some_and(|last| last.trim().eq_ignore_ascii_case("base64"));
    if !is_base64 {
        return Ok(percent_decoded(text));
    }
    let is_clean = text.bytes().all(|byte| byte.is_ascii_alphanumeric() || b"+/=".contains(&byte));
    let decoded = if is_clean {
        LENIENT.decode(text)
    } else {
        let mut letters = percent_decoded(text);
        letters.retain(|byte| !byte.is_ascii_whitespace());
        for letter in &mut letters {
            *letter = match *letter {
                b'-' => b'+',
                b'_' => b'/',
                other => other,
            };
        }
        LENIENT.decode(letters)
    };
    decoded.map_err(|error| Fault::Invalid(format!("a data URI is no base64: {error}")))
}

/// Padding is often left out.
const LENIENT: GeneralPurpose = GeneralPurpose::new(
    &base64::alphabet::STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// `%20` to a blank and so on (RFC 3986, section 2.1). A percent sign without two digits stands for itself.
fn percent_decoded(uri: &str) -> Vec<u8> {
    let digit = |byte: &u8| char::from(*byte).to_digit(16).map(|digit| digit as u8);
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let [first, after @ ..] = rest {
        let code = match after {
            [high, low, ..] if *first == b'%' => digit(high).zip(digit(low)),
            _ => None,
        };
        bytes.push(code.map_or(*first, |(high, low)| 16 * high + low));
        rest = if code.is_some() { &after[2..] } else { after };
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    fn data(text: &str) -> Result<Vec<u8>, Fault> {
        embedded(text, &mut Budget::new(1 << 20))
    }

    #[test]
    fn percent_sequences_decode_and_bare_percents_stay() {
        for (text, bytes) in [
            ("a%20b", &b"a b"[..]),
            ("%E2%82%ac", "\u{20ac}".as_bytes()),
            ("50% grey", b"50% grey"),
            ("a%2", b"a%2"),
            ("%", b"%"),
            ("%%41", b"%A"),
            ("%zz%é", "%zz%é".as_bytes()),
        ] {
            assert_eq!(percent_decoded(text), bytes, "{text}");
        }
    }

    #[test]
    fn data_uris_of_all_kinds() {
        for text in [
            ";base64,AAEC",
            "application/octet-stream;base64,AAEC",
            "a/b;charset=utf-8;BASE64,AA\n EC",
            "a/b;base64,%41AEC",
            ",%00%01%02",
            "a/b,%00%01%02",
        ] {
            assert_eq!(data(text).unwrap(), [0, 1, 2], "{text}");
        }
        assert_eq!(data(";base64,-_8").unwrap(), data(";base64,+/8=").unwrap());
        assert_eq!(data(";base64,AAE").unwrap(), data(";base64,AAE=").unwrap());
        assert!(data(";base64,AA*C").is_err());
        assert!(data("no comma").is_err());
    }

    #[test]
    fn schemes_are_told_without_case() {
        assert_eq!(strip_scheme("DATA:x", "data"), Some("x"));
        assert_eq!(scheme("a b:c"), None);
        assert_eq!(scheme("C:\\x.png"), Some("C"));
    }
}
