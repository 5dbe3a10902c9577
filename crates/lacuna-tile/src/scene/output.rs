//! Where a file of the scene lies in the output.

use super::error::SceneError;
use std::path::{Path, PathBuf};

/// Longest name of one folder or file, bytes, that common file systems take.
const MAX_NAME_BYTES: usize = 255;

/// The place of `relative` (forward slashes) under `out`.
///
/// # Errors
/// A path that is empty or absolute, or has a component that is empty, `.`, `..`, longer than 255 bytes, or holds a NUL or
/// a separator of another system: such a path could lead out of `out`.
pub fn output_path(out: &Path, relative: &str) -> Result<PathBuf, SceneError> {
    let mut path = out.to_owned();
    for component in relative.split('/') {
        if let Some(problem) = problem_of(component) {
            return Err(SceneError::UnsafePath { relative: relative.to_owned(), problem });
        }
        path.push(component);
    }
    Ok(path)
}

fn problem_of(component: &str) -> Option<&'static str> {
    let drive = component.len() >= 2 && component.as_bytes()[1] == b':';
    match component {
        "" => Some("it is absolute, or has an empty component"),
        "." | ".." => Some("it has a component . or .."),
        _ if component.len() > MAX_NAME_BYTES => Some("a component is longer than 255 bytes"),
        _ if component.contains('\0') => Some("it holds a NUL"),
        _ if cfg!(windows) && (drive || component.contains('\\')) => Some("it holds a drive or a backslash"),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_stay_inside_the_output() {
        let out = Path::new("out");
        for good in
            ["a.obj", "Data/Tile_+000_+001/a b.obj", "..a/b..", ".hidden", "a:b", "CON", "é/\u{202e}x"]
        {
            let path = output_path(out, good).expect(good);
            assert_eq!(path, out.join(good));
        }
        let long = "x".repeat(256);
        for bad in ["", "/etc/passwd", "../a", "a/../../b", "a//b", "a/", "./a", "a\0b", &long] {
            assert!(output_path(out, bad).is_err(), "{bad:?} is refused");
        }
    }
}
