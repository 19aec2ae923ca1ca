//! URIs: data inside of the document, and paths next to it.

use std::path::{Component, Path, PathBuf};

use super::context::Outcome;

/// What a URI stands for.
#[derive(Debug, PartialEq)]
pub enum Uri {
    /// The bytes of a `data:` URI.
    Data(Vec<u8>),
    /// A path relative to the document's folder: decoded, and as it was written for files whose
    /// names hold percent signs.
    Relative(PathBuf, PathBuf),
}

/// Takes a URI apart. Absolute paths and schemes other than `data:` are refused: a scene is read
/// from the disk, next to its document.
pub fn parse(uri: &str) -> Outcome<Uri> {
    if uri.get(..5).is_some_and(|scheme| scheme.eq_ignore_ascii_case("data:")) {
        return data(&uri[5..]).map(Uri::Data);
    }
    if let Some(scheme) = scheme(uri) {
        return Err(format!(
            "the URI has the scheme \"{scheme}:\"; only relative paths and data URIs are read"
        ));
    }
    let decoded = String::from_utf8(percent_decode(uri)?)
        .map_err(|_| "the URI is not UTF-8 after percent-decoding".to_owned())?;
    if decoded.is_empty() {
        return Err("the URI is empty".to_owned());
    }
    let (decoded, written) = (PathBuf::from(decoded), PathBuf::from(uri));
    for path in [&decoded, &written] {
        if !is_relative(path) {
            return Err("the URI is an absolute path; only relative paths and data URIs are read".to_owned());
        }
    }
    Ok(Uri::Relative(decoded, written))
}

fn is_relative(path: &Path) -> bool {
    let leading = path.to_string_lossy();
    !leading.starts_with(['/', '\\'])
        && path.components().all(|part| !matches!(part, Component::Prefix(_) | Component::RootDir))
}

/// What stands before the first colon where it looks like a scheme (RFC 3986) or a drive letter.
fn scheme(uri: &str) -> Option<&str> {
    let (scheme, _) = uri.split_once(':')?;
    let mut letters = scheme.chars();
    let valid = letters.next()?.is_ascii_alphabetic()
        && letters.all(|c| c.is_ascii_alphanumeric() || matches!(c, '+' | '-' | '.'));
    valid.then_some(scheme)
}

/// The bytes of a data URI whose `data:` is already off.
fn data(rest: &str) -> Outcome<Vec<u8>> {
    let (kind, payload) = rest.split_once(',').ok_or("the data URI has no comma")?;
    let is_base64 = kind
        .rsplit(';')
        .next()
        .is_some_and(|last| kind.contains(';') && last.trim().eq_ignore_ascii_case("base64"));
    if !is_base64 {
        return percent_decode(payload);
    }
    if payload.contains('%') {
        return base64(&percent_decode(payload)?);
    }
    base64(payload.as_bytes())
}

fn percent_decode(text: &str) -> Outcome<Vec<u8>> {
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text.bytes();
    while let Some(byte) = rest.next() {
        if byte != b'%' {
            bytes.push(byte);
            continue;
        }
        let mut digit = || rest.next().and_then(|b| char::from(b).to_digit(16));
        match (digit(), digit()) {
            // Two hexadecimal digits are below 256.
            (Some(high), Some(low)) => bytes.push((high * 16 + low) as u8),
            _ => return Err("the URI has a percent sign without two hexadecimal digits".to_owned()),
        }
    }
    Ok(bytes)
}

/// Base64 of RFC 4648, with or without padding; blanks and line ends are skipped.
fn base64(text: &[u8]) -> Outcome<Vec<u8>> {
    let mut bytes = Vec::with_capacity(text.len() / 4 * 3 + 3);
    let (mut bits, mut held, mut digits, mut padding) = (0u32, 0u32, 0usize, 0usize);
    for &byte in text {
        let digit = match byte {
            b'A'..=b'Z' => byte - b'A',
            b'a'..=b'z' => byte - b'a' + 26,
            b'0'..=b'9' => byte - b'0' + 52,
            b'+' | b'-' => 62,
            b'/' | b'_' => 63,
            b'=' => {
                padding += 1;
                continue;
            }
            b' ' | b'\t' | b'\r' | b'\n' => continue,
            _ => return Err("the data URI holds a character that is not base64".to_owned()),
        };
        if padding > 0 {
            return Err("the data URI's base64 goes on after its padding".to_owned());
        }
        digits += 1;
        bits = bits << 6 | u32::from(digit);
        held += 6;
        if held >= 8 {
            held -= 8;
            bytes.push((bits >> held) as u8);
            bits &= (1 << held) - 1;
        }
    }
    if digits % 4 == 1 || padding > 2 {
        return Err("the data URI's base64 is cut off".to_owned());
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn data_uris() {
        assert_eq!(parse("data:;base64,AAEC/w=="), Ok(Uri::Data(vec![0, 1, 2, 255])));
        assert_eq!(parse("data:text/plain;base64,aGk"), Ok(Uri::Data(b"hi".to_vec())));
        assert_eq!(parse("data:text/plain,a%20b"), Ok(Uri::Data(b"a b".to_vec())));
        assert!(parse("data:;base64,A").is_err());
        assert!(parse("data:;base64,A!==").is_err());
        assert!(parse("data:nothing").is_err());
    }

    #[test]
    fn paths() {
        let relative = |a: &str, b: &str| Ok(Uri::Relative(a.into(), b.into()));
        assert_eq!(parse("a%20b.bin"), relative("a b.bin", "a%20b.bin"));
        assert_eq!(parse("../textures/ä.png"), relative("../textures/ä.png", "../textures/ä.png"));
        for refused in
            ["/etc/passwd", "%2Fetc/passwd", "http://a/b", "file:///a", "C:\\a", "\\\\a\\b", "", "%"]
        {
            assert!(parse(refused).is_err(), "{refused}");
        }
    }
}
