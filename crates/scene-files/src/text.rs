//! Text as programs write it: encodings, line ends, numbers and names of OBJ, MTL, PLY and STL files.

use std::borrow::Cow;
use std::ops::Range;

use gnomon_messages::quoted;

/// The text of a file: UTF-8, UTF-16 where a byte order mark says so, else Latin-1, in which every byte is a letter.
pub fn decode(bytes: &[u8]) -> Cow<'_, str> {
    let utf16 = |bytes: &[u8], unit: fn([u8; 2]) -> u16| {
        let (units, _) = bytes.as_chunks::<2>();
        Cow::Owned(String::from_utf16_lossy(&units.iter().map(|&pair| unit(pair)).collect::<Vec<_>>()))
    };
    if let Some(rest) = bytes.strip_prefix(b"\xff\xfe") {
        return utf16(rest, u16::from_le_bytes);
    }
    if let Some(rest) = bytes.strip_prefix(b"\xfe\xff") {
        return utf16(rest, u16::from_be_bytes);
    }
    let bytes = super::without_bom(bytes);
    match std::str::from_utf8(bytes) {
        Ok(text) => Cow::Borrowed(text),
        Err(_) => Cow::Owned(bytes.iter().map(|&byte| char::from(byte)).collect()),
    }
}

/// Lines with their numbers from 1, ended by LF, CR LF or CR, trimmed.
pub fn lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut rest = Some(text);
    let lines = std::iter::from_fn(move || {
        let text = rest?;
        let Some(end) = text.find(['\n', '\r']) else {
            rest = None;
            return Some(text);
        };
        let after = &text[end + 1..];
        let is_pair = text.as_bytes()[end] == b'\r';
        rest = Some(if is_pair { after.strip_prefix('\n').unwrap_or(after) } else { after });
        Some(&text[..end])
    });
    lines.enumerate().map(|(index, line)| (index + 1, line.trim()))
}

/// Keyword and what follows it.
pub fn statement(line: &str) -> (&str, &str) {
    let (keyword, rest) = line.split_once(|c: char| c.is_ascii_whitespace()).unwrap_or((line, ""));
    (keyword, rest.trim())
}

/// A number as any run-time library prints it: also `-1.#IND` and the like, which are none, and with a decimal comma.
pub fn number(word: &str) -> Option<f64> {
    if let Ok(number) = word.parse() {
        return Some(number);
    }
    let lower = word.trim_start_matches(['+', '-']).to_ascii_lowercase();
    if lower.contains("#inf") {
        return Some(if word.starts_with('-') { f64::NEG_INFINITY } else { f64::INFINITY });
    }
    if lower.starts_with("nan") || ["#ind", "#qnan", "#snan"].iter().any(|mark| lower.contains(mark)) {
        return Some(f64::NAN);
    }
    // A comma is a decimal one where a word holds one alone, and no point.
    let has_one_comma = word.bytes().filter(|&byte| byte == b',').count() == 1 && !word.contains('.');
    has_one_comma.then(|| word.replace(',', ".").parse().ok()).flatten()
}

/// Up to `N` numbers and how many there were (more are ignored); at least `least` of them must be there, else it says what is wrong.
pub fn numbers<const N: usize>(text: &str, least: usize) -> Result<([f64; N], usize), String> {
    let mut values = [0.0; N];
    let mut count = 0;
    for word in text.split_ascii_whitespace().take(N) {
        values[count] = number(word).ok_or_else(|| format!("'{}' is no number", quoted(word)))?;
        count += 1;
    }
    if count < least {
        return Err(format!("{least} numbers expected, {count} found"));
    }
    Ok((values, count))
}

/// The numbers before a comment; `1.#IND` is none. Names may hold a `#`: [`names`] is for these.
pub fn without_comment(text: &str) -> &str {
    let comment = text.match_indices('#').map(|(at, _)| at).find(|&at| !text[..at].ends_with('.'));
    text[..comment.unwrap_or(text.len())].trim_end()
}

/// What a name may be, the most likely first: all of the text, or what stands before a comment; without quotes.
pub fn names(text: &str) -> impl Iterator<Item = &str> {
    let comment = text.match_indices('#').map(|(at, _)| at).find(|&at| text[..at].ends_with([' ', '\t']));
    std::iter::once(text).chain(comment.map(|at| &text[..at])).map(unquoted)
}

fn unquoted(text: &str) -> &str {
    let text = text.trim();
    let inner = ['"', '\''].iter().find_map(|&quote| text.strip_prefix(quote)?.strip_suffix(quote));
    inner.unwrap_or(text).trim()
}

/// Places of the words in a text; what stands in double quotes is one word.
pub fn words(text: &str) -> impl Iterator<Item = Range<usize>> {
    let mut at = 0;
    std::iter::from_fn(move || {
        let rest = &text[at..];
        let start = at + rest.len() - rest.trim_start().len();
        let word = &text[start..];
        let end = match word.strip_prefix('"').and_then(|inner| inner.find('"')) {
            Some(close) => close + 2,
            None => word.find(char::is_whitespace).unwrap_or(word.len()),
        };
        at = start + end;
        (end > 0).then_some(start..at)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_encoding_and_line_end_gives_the_same_lines() {
        let text = "a ü\n b\n\nc";
        let utf16 = |unit: fn(u16) -> [u8; 2]| -> Vec<u8> {
            std::iter::once(0xfeff).chain(text.encode_utf16()).flat_map(unit).collect()
        };
        let files = [
            text.as_bytes().to_vec(),
            format!("\u{feff}{text}").into_bytes(),
            utf16(u16::to_le_bytes),
            utf16(u16::to_be_bytes),
            text.replace('\n', "\r\n").into_bytes(),
            text.replace('\n', "\r").into_bytes(),
            b"a \xfc\n b\n\nc".to_vec(),
        ];
        for file in files {
            let decoded = decode(&file);
            assert_eq!(
                lines(&decoded).collect::<Vec<_>>(),
                [(1, "a ü"), (2, "b"), (3, ""), (4, "c")],
                "{file:?}"
            );
        }
    }

    #[test]
    fn numbers_are_read_as_programs_print_them() {
        for (word, value) in [("1.5", 1.5), ("-2e3", -2000.0), ("0,25", 0.25), ("-1.#INF", f64::NEG_INFINITY)]
        {
            assert_eq!(number(word), Some(value), "{word}");
        }
        for word in ["nan", "-NaN", "-1.#IND", "1.#QNAN", "1.#QNAN0", "-nan(ind)"] {
            assert!(number(word).is_some_and(f64::is_nan), "{word}");
        }
        for word in ["", "x", "1,2,3", "1,000.5", "0x10"] {
            assert_eq!(number(word), None, "{word}");
        }
    }

    #[test]
    fn comments_end_numbers() {
        assert_eq!(without_comment("1 2 3 # 4"), "1 2 3");
        assert_eq!(without_comment("-1.#IND 1.#QNAN 0#"), "-1.#IND 1.#QNAN 0");
    }

    #[test]
    fn names_may_hold_what_looks_like_a_comment() {
        let names = |text| names(text).collect::<Vec<_>>();
        assert_eq!(names("Material #25"), ["Material #25", "Material"]);
        assert_eq!(names("a#b"), ["a#b"]);
        assert_eq!(names("\"my stone\"  # note"), ["\"my stone\"  # note", "my stone"]);
        let words = |text: &'static str| words(text).map(|range| &text[range]).collect::<Vec<_>>();
        assert_eq!(words(" a  \"b c\" d\te "), ["a", "\"b c\"", "d", "e"]);
        assert!(words("  ").is_empty());
    }
}
