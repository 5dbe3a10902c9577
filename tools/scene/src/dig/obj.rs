//! Faces of an OBJ file with the lines that hold them.

use super::faces::TileFaces;

/// Reads positions and faces; a line that ends in `\` goes on in the next one.
pub(super) fn read(bytes: &[u8]) -> Result<TileFaces, String> {
    let mut faces = TileFaces::default();
    let mut start = 0;
    let mut line = 0;
    while start < bytes.len() {
        let end = statement_end(bytes, start);
        line += 1;
        let statement = &bytes[start..end];
        let text = || String::from_utf8_lossy(statement).replace("\\\r\n", " ").replace("\\\n", " ");
        match statement.trim_ascii_start() {
            [b'v', b' ' | b'\t', ..] => {
                faces
                    .positions
                    .push(position(&text()).ok_or_else(|| format!("statement {line}: bad vertex"))?);
            }
            [b'f', b' ' | b'\t', ..] => {
                let known = faces.positions.len();
                faces.corners.extend(content(&text()).skip(1).map(|word| corner(word, known)));
                faces.ends.push(faces.corners.len());
                faces.bytes.push(start..end);
            }
            _ => {}
        }
        start = end;
    }
    Ok(faces)
}

/// The end of the statement that starts here, line break included.
fn statement_end(bytes: &[u8], start: usize) -> usize {
    let mut from = start;
    while let Some(offset) = bytes[from..].iter().position(|&b| b == b'\n') {
        let end = from + offset + 1;
        let line = bytes[from..end - 1].strip_suffix(b"\r").unwrap_or(&bytes[from..end - 1]);
        if !line.ends_with(b"\\") {
            return end;
        }
        from = end;
    }
    bytes.len()
}

fn content(text: &str) -> impl Iterator<Item = &str> {
    text.split('#').next().unwrap_or_default().split_ascii_whitespace()
}

fn position(text: &str) -> Option<[f64; 3]> {
    let mut numbers = content(text).skip(1).map(|word| word.parse::<f64>().ok());
    Some([numbers.next()??, numbers.next()??, numbers.next()??])
}

/// A face corner's vertex; `usize::MAX` if it is none.
fn corner(word: &str, known: usize) -> usize {
    let index = word.split('/').next().and_then(|i| i.parse::<i64>().ok());
    let absolute = index.map(|i| if i < 0 { known as i64 + i } else { i - 1 });
    absolute.and_then(|i| usize::try_from(i).ok()).filter(|&i| i < known).unwrap_or(usize::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_dialects_and_takes_out_whole_statements() {
        let text = b"mtllib a b.mtl\r\nv 0 0 0\nv 1 0 0\n  v 0 1 0 # corner\nvn 0 0 1\nf 1//1 2//1 \\\n 3//1\nf -3/ -2/ -1/\nf 1 2 9\nl 1 2";
        let faces = read(text).unwrap();
        assert_eq!(faces.positions, [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        assert_eq!(faces.corners, [0, 1, 2, 0, 1, 2, 0, 1, usize::MAX]);
        assert_eq!(faces.centroid(2), None);
        let left = faces.without(text, |f| f == 0);
        let expected: &[u8] =
            b"mtllib a b.mtl\r\nv 0 0 0\nv 1 0 0\n  v 0 1 0 # corner\nvn 0 0 1\nf -3/ -2/ -1/\nf 1 2 9\nl 1 2";
        assert_eq!(left, expected);
        assert_eq!(faces.without(text, |_| false), text);
    }

    #[test]
    fn a_vertex_without_numbers_is_named() {
        assert_eq!(read(b"v 0 0 0\nv a b c\n").unwrap_err(), "statement 2: bad vertex");
    }
}
