//! Buffers outside the BIN chunk: `data:` URIs and files beside the tile.

use std::fs::File;
use std::io;
use std::path::Path;

/// Longest relative URI that is taken for a path, bytes.
const MAX_URI_BYTES: usize = 4096;

/// The bytes of a `data:` URI; `None` if it is another kind of URI.
///
/// # Errors
/// Text that is not base64.
pub(super) fn data_uri(uri: &str) -> Option<Result<Vec<u8>, String>> {
    let rest = uri.strip_prefix("data:")?;
    let Some((kind, content)) = rest.split_once(',') else {
        return Some(Err("a data URI without a comma".to_owned()));
    };
    if !kind.ends_with(";base64") {
        return Some(Err("a data URI that is not base64".to_owned()));
    }
    Some(decode_base64(content))
}

/// Decodes base64 (RFC 4648, section 4), with or without padding.
fn decode_base64(text: &str) -> Result<Vec<u8>, String> {
    let text = text.trim_end_matches('=').as_bytes();
    let mut bytes = Vec::with_capacity(text.len() / 4 * 3 + 2);
    for chunk in text.chunks(4) {
        let mut bits = 0_u32;
        for &letter in chunk {
            bits = bits << 6 | sextet(letter).ok_or("a data URI with a letter that is not base64")?;
        }
        let missing = 4 - chunk.len();
        if missing == 3 {
            return Err("a data URI that ends in the middle of a byte".to_owned());
        }
        let word = (bits << (6 * missing)).to_be_bytes();
        bytes.extend_from_slice(&word[1..4 - missing]);
    }
    Ok(bytes)
}

fn sextet(letter: u8) -> Option<u32> {
    Some(u32::from(match letter {
        b'A'..=b'Z' => letter - b'A',
        b'a'..=b'z' => letter - b'a' + 26,
        b'0'..=b'9' => letter - b'0' + 52,
        b'+' => 62,
        b'/' => 63,
        _ => return None,
    }))
}

/// Encodes base64 (RFC 4648, section 4), padded.
pub(super) fn encode_base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for chunk in bytes.chunks(3) {
        let byte = |k: usize| u32::from(chunk.get(k).copied().unwrap_or(0));
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        for k in 0..4 {
            let letter = LETTERS[(bits >> (18 - 6 * k) & 63) as usize];
            text.push(if k <= chunk.len() { char::from(letter) } else { '=' });
        }
    }
    text
}

/// The path below the tile's folder that a relative URI names, percent signs decoded.
///
/// # Errors
/// Everything that is absolute, has a scheme, climbs, or holds a backslash, a control character, a query or a fragment.
pub(super) fn safe_relative(uri: &str) -> Result<String, &'static str> {
    if uri.len() > MAX_URI_BYTES {
        return Err("a URI longer than 4096 bytes");
    }
    if uri.contains(['?', '#']) {
        return Err("a URI with a query or a fragment");
    }
    let path = decode_percent(uri).ok_or("a URI with a broken percent code")?;
    if path.contains(|c: char| c.is_control() || c == '\\' || c == ':') {
        return Err("a URI with a scheme, a drive, a backslash or a control character");
    }
    let climbs = |component: &str| component.is_empty() || component == "..";
    if path.split('/').any(climbs) {
        return Err("a URI that is absolute or leaves the tile's folder");
    }
    Ok(path)
}

fn decode_percent(uri: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let Some((&byte, after)) = rest.split_first() {
        if byte != b'%' {
            bytes.push(byte);
            rest = after;
            continue;
        }
        let digit = |k: usize| after.get(k).and_then(|&d| char::from(d).to_digit(16));
        bytes.push(u8::try_from(digit(0)? * 16 + digit(1)?).ok()?);
        rest = &after[2..];
    }
    String::from_utf8(bytes).ok()
}

/// Opens a file below a folder for reading, without waiting; symbolic links on the way must not leave the folder.
///
/// # Errors
/// As the system; `PermissionDenied` or `EXDEV` for a way out.
pub(super) fn open_beneath(folder: &Path, relative: &str) -> io::Result<File> {
    #[cfg(target_os = "linux")]
    match open_beneath_kernel(folder, relative) {
        Err(rustix::io::Errno::NOSYS) => {} // before Linux 5.6
        result => return Ok(File::from(result?)),
    }
    open_beneath_checked(folder, relative)
}

#[cfg(target_os = "linux")]
fn open_beneath_kernel(folder: &Path, relative: &str) -> rustix::io::Result<std::os::fd::OwnedFd> {
    use rustix::fs::{CWD, Mode, OFlags, ResolveFlags, openat, openat2};
    let flags = OFlags::PATH | OFlags::DIRECTORY | OFlags::CLOEXEC;
    let directory = openat(CWD, folder, flags, Mode::empty())?;
    let flags = OFlags::RDONLY | OFlags::NONBLOCK | OFlags::CLOEXEC;
    let resolve = ResolveFlags::BENEATH | ResolveFlags::NO_MAGICLINKS;
    openat2(&directory, relative, flags, Mode::empty(), resolve)
}

fn open_beneath_checked(folder: &Path, relative: &str) -> io::Result<File> {
    let real_folder = std::fs::canonicalize(folder)?;
    let real = std::fs::canonicalize(folder.join(relative))?;
    let inside = real.starts_with(&real_folder) && std::fs::metadata(&real)?.is_file();
    if inside { File::open(real) } else { Err(io::Error::from(io::ErrorKind::PermissionDenied)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uris_that_leave_the_folder_are_refused() {
        let long = "a".repeat(65_536);
        let bad = [
            "../a.bin",
            "a/../../b",
            "%2e%2e/secret.bin",
            "%2E%2E%2Fx",
            "..\\a",
            "..%5ca",
            "/etc/hostname",
            "//host/a",
            "file:///etc/hostname",
            "http://host/a",
            "C:/a",
            "a%00b",
            "%FF%FE",
            "a%2",
            "a%zz",
            "",
            "a//b",
            "a?b",
            "a#b",
            "a\nb",
            &long,
        ];
        for uri in bad {
            assert!(safe_relative(uri).is_err(), "{:?} is refused", &uri[..uri.len().min(40)]);
        }
    }

    #[test]
    fn ordinary_uris_become_paths() {
        for (uri, path) in
            [("a.bin", "a.bin"), ("./a/b.bin", "./a/b.bin"), ("a%20b.bin", "a b.bin"), ("%C3%A9", "é")]
        {
            assert_eq!(safe_relative(uri).as_deref(), Ok(path));
        }
    }

    #[test]
    fn base64_goes_both_ways() {
        for length in 0..20_u8 {
            let bytes: Vec<u8> = (0..length).map(|k| k.wrapping_mul(91)).collect();
            let uri = format!("data:application/octet-stream;base64,{}", encode_base64(&bytes));
            assert_eq!(data_uri(&uri), Some(Ok(bytes)));
        }
        assert_eq!(encode_base64(b"glTF"), "Z2xURg==");
    }

    #[test]
    fn broken_data_uris_are_errors() {
        for uri in ["data:,abc", "data:;base64", "data:;base64,A", "data:;base64,A*AA", "data:;base64,AA=A"] {
            assert!(matches!(data_uri(uri), Some(Err(_))), "{uri}");
        }
        assert_eq!(data_uri("a.bin"), None);
    }
}
