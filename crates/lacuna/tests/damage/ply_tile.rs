//! A tile in binary little-endian PLY with `float x y z` and triangles, as the small scene has them, taken apart.

use std::path::Path;

/// A repaired tile: the first rows are the delivered ones.
#[derive(Clone, Debug)]
pub(crate) struct PlyTile {
    /// Lines of the header, its last one included.
    pub(crate) header: Vec<String>,
    pub(crate) vertices: Vec<[f32; 3]>,
    pub(crate) faces: Vec<[u32; 3]>,
    /// Number of delivered vertices.
    pub(crate) old_vertices: usize,
    /// Number of delivered faces.
    pub(crate) old_faces: usize,
}

impl PlyTile {
    /// Reads a repaired tile. What was delivered comes before the first mark's ranges; without a mark it is everything.
    pub(crate) fn read(path: &Path) -> Self {
        let bytes = std::fs::read(path).expect("a tile");
        let end = find(&bytes, b"end_header\n").expect("a header") + b"end_header\n".len();
        let text = std::str::from_utf8(&bytes[..end]).expect("UTF-8");
        let header: Vec<String> = text.lines().map(str::to_owned).collect();
        let (vertex_count, face_count) = (count(&header, "vertex"), count(&header, "face"));
        let (rows, faces) = bytes[end..].split_at(vertex_count * 12);
        let number = |b: &[u8], k: usize| -> [u8; 4] { b[4 * k..4 * k + 4].try_into().expect("four bytes") };
        let vertex = |row: &[u8]| [0, 1, 2].map(|k| f32::from_le_bytes(number(row, k)));
        let face = |row: &[u8]| [0, 1, 2].map(|k| u32::from_le_bytes(number(&row[1..], k)));
        let (old_vertices, old_faces) =
            header.iter().find_map(|line| first_of_mark(line)).unwrap_or((vertex_count, face_count));
        let tile = Self {
            vertices: rows.chunks_exact(12).map(vertex).collect(),
            faces: faces.chunks_exact(13).map(face).collect(),
            header,
            old_vertices,
            old_faces,
        };
        assert_eq!((tile.vertices.len(), tile.faces.len()), (vertex_count, face_count), "{}", path.display());
        tile
    }

    /// Writes the tile with its present counts; the last mark reaches to the last rows.
    pub(crate) fn write(&self, path: &Path) {
        let mut header = self.header.clone();
        let (vertices, faces) = (self.vertices.len(), self.faces.len());
        let last = header.iter().rposition(|line| line.starts_with("comment lacuna patch"));
        for (number, line) in header.iter_mut().enumerate() {
            if line.starts_with("element vertex") {
                *line = format!("element vertex {vertices}");
            } else if line.starts_with("element face") {
                *line = format!("element face {faces}");
            } else if Some(number) == last {
                *line = stretched(line, vertices, faces);
            }
        }
        let mut bytes = (header.join("\n") + "\n").into_bytes();
        self.vertices.iter().flatten().for_each(|x| bytes.extend(x.to_le_bytes()));
        for face in &self.faces {
            bytes.push(3);
            face.iter().for_each(|v| bytes.extend(v.to_le_bytes()));
        }
        std::fs::write(path, bytes).expect("written");
    }

    /// The corners of a face.
    pub(crate) fn corners(&self, face: usize) -> [[f32; 3]; 3] {
        self.faces[face].map(|v| self.vertices[v as usize])
    }
}

fn find(bytes: &[u8], what: &[u8]) -> Option<usize> {
    bytes.windows(what.len()).position(|w| w == what)
}

fn count(header: &[String], element: &str) -> usize {
    let line = header.iter().find_map(|l| l.strip_prefix(&format!("element {element} ")));
    line.expect("an element").parse().expect("a count")
}

fn first_of_mark(line: &str) -> Option<(usize, usize)> {
    let rest = line.strip_prefix("comment lacuna patch: vertices ")?;
    let first = |text: &str| text.split("..").next()?.parse().ok();
    let mut words = rest.split(' ');
    Some((first(words.next()?)?, first(words.nth(1)?)?))
}

fn stretched(mark: &str, vertices: usize, faces: usize) -> String {
    let words: Vec<&str> = mark.split(' ').collect();
    let to = |range: &str, end: usize| format!("{}..{}", range.split("..").next().expect("a start"), end - 1);
    format!(
        "comment lacuna patch: vertices {} faces {} hole {}",
        to(words[4], vertices),
        to(words[6], faces),
        words[8]
    )
}
