//! Appends patches to an OBJ file: every original byte, then statements of our own, with a material in a file of its
//! own.

use super::read::frame;
use super::rows::{Rows, StoredVertex, find_rows};
use crate::atomic::AtomicFile;
use crate::error::TileError;
use crate::fault::Fault;
use crate::patches::{FilePatch, check_patches, comment_text, original_corners, to_file_frame};
use crate::source::load_expected;
use crate::types::{AppendRequest, Corner, HolePatch, NewTileRequest, UpAxis, VertexFrame, Written};
use glam::DVec3;
use std::fmt::Write as _;
use std::io::Write;
use std::path::Path;

const MATERIAL: &str = "lacuna_patch";
const MIDDLE_GREY: [f64; 4] = [0.5, 0.5, 0.5, 1.0];

/// Writes an OBJ tile again with patches appended, and `<tile>_lacuna.mtl` beside it.
///
/// # Errors
/// As `append_patches`.
pub(crate) fn append(request: &AppendRequest<'_>) -> Result<Written, TileError> {
    let source = load_expected(request.input, request.options, request.expected_hash)?;
    if request.patches.is_empty() {
        return write_tile(request.output, &source.bytes, "");
    }
    let rows = find_rows(&source.bytes).map_err(|fault| fault.at(request.input))?;
    check_patches(request.input, request.patches, rows.vertex_count())?;
    let library = library_name(request.output, request.input.parent());
    let up_axis = request.options.up_axis.unwrap_or(UpAxis::Z);
    let origin = Origin { vertices: rows.vertex_count(), normals: rows.normals };
    let text = patch_text(&rows, request.patches, &frame(up_axis), origin, &library);
    let text = text.map_err(|fault| fault.at(request.input))?;
    write_with_library(request.output, &source.bytes, &text, &library)
}

/// Writes an OBJ tile of patches alone, coloured and with normals as the template is.
///
/// # Errors
/// As `new_tile`.
pub(crate) fn new_tile(request: &NewTileRequest<'_>) -> Result<Written, TileError> {
    let source = load_expected(request.template, request.options, None)?;
    let rows = find_rows(&source.bytes).map_err(|fault| fault.at(request.template))?;
    check_patches(request.output, request.patches, 0)?;
    let library = library_name(request.output, None);
    let up_axis = request.options.up_axis.unwrap_or(UpAxis::Z);
    let text = patch_text(&rows, request.patches, &frame(up_axis), Origin::default(), &library);
    let text = text.map_err(|fault| fault.at(request.template))?;
    write_with_library(request.output, b"", &text, &library)
}

/// The name of the patch material's file: `<tile>_lacuna.mtl`, numbered where the input has such a file already (it was
/// repaired before) and keeps it.
fn library_name(output: &Path, input_folder: Option<&Path>) -> String {
    let stem = comment_text(&output.file_stem().unwrap_or_default().to_string_lossy());
    let is_taken = |name: &String| input_folder.is_some_and(|folder| folder.join(name).exists());
    let numbered = (2..).map(|k| format!("{stem}_lacuna{k}.mtl"));
    let mut names = std::iter::once(format!("{stem}_lacuna.mtl")).chain(numbered);
    names.find(|name| !is_taken(name)).unwrap_or_default()
}

/// Our statements, and the colour of our material.
struct PatchText {
    statements: String,
    material_colour: [f64; 3],
}

/// The material first, so that the tile never names a file that isn't there.
fn write_with_library(
    output: &Path,
    original: &[u8],
    text: &PatchText,
    library: &str,
) -> Result<Written, TileError> {
    let [r, g, b] = text.material_colour.map(short);
    let material =
        format!("# lacuna patch\nnewmtl {MATERIAL}\nKa 0 0 0\nKd {r} {g} {b}\nKs 0 0 0\nd 1\nillum 1\n");
    write_tile(&output.with_file_name(library), b"", &material)?;
    let written = write_tile(output, original, &text.statements)?;
    Ok(Written { side_files: vec![library.to_owned()], ..written })
}

fn write_tile(output: &Path, original: &[u8], text: &str) -> Result<Written, TileError> {
    let mut file = AtomicFile::create(output)?;
    for piece in [original, if text.is_empty() { b"" } else { closing(original) }, text.as_bytes()] {
        file.write_all(piece).map_err(|e| TileError::io(output, "write", e))?;
    }
    let committed = file.commit()?;
    Ok(Written { bytes: committed.bytes, hash: committed.hash, side_files: Vec::new() })
}

/// What must stand between the original's last byte and a new statement: the missing line end; behind a `\` that would
/// draw our first line to it, an empty line.
fn closing(original: &[u8]) -> &'static [u8] {
    let line = original.strip_suffix(b"\n");
    let is_closed = original.is_empty() || line.is_some();
    let line = line.unwrap_or(original);
    match (line.strip_suffix(b"\r").unwrap_or(line).ends_with(b"\\"), is_closed) {
        (true, false) => b"\n\n",
        (true, true) | (false, false) => b"\n",
        (false, true) => b"",
    }
}

/// How many vertices and normals stand before ours.
#[derive(Clone, Copy, Default)]
struct Origin {
    vertices: u64,
    normals: u64,
}

/// Steps: 1. our material and group; 2. new vertices of all patches, with colours in the file's own form; 3. normals of
/// all corners, if the file has normals; 4. the faces of each hole, with absolute indices.
fn patch_text(
    rows: &Rows<'_>,
    patches: &[HolePatch],
    frame: &VertexFrame,
    origin: Origin,
    library: &str,
) -> Result<PatchText, Fault> {
    let pieces = gather(rows, patches, frame)?;
    let mut lines = Lines { text: String::new(), newline: rows.newline };
    for line in ["# lacuna patch", &format!("mtllib {library}"), &format!("g {MATERIAL}")] {
        lines.add(line);
    }
    lines.add(&format!("usemtl {MATERIAL}"));
    lines.add("s off");
    for piece in &pieces {
        piece.local.vertices.iter().for_each(|v| lines.vertex(*v, &piece.colour[..rows.colour_columns]));
    }
    let has_normals = rows.normals > 0;
    if has_normals {
        let normals =
            |piece: &Piece| [piece.local.original_normals.clone(), piece.local.normals.clone()].concat();
        pieces.iter().flat_map(normals).for_each(|n| lines.normal(n));
    }
    let mut next = origin;
    for (patch, piece) in patches.iter().zip(&pieces) {
        lines.add(&format!("# hole {}", comment_text(&patch.hole)));
        patch.triangles.iter().for_each(|t| lines.face(t, &piece.originals, next, has_normals));
        next.vertices += piece.local.vertices.len() as u64;
        next.normals += (piece.originals.len() + piece.local.normals.len()) as u64;
    }
    Ok(PatchText { statements: lines.text, material_colour: material_colour(rows, &pieces) })
}

/// A patch with what the tile knows about its rim.
struct Piece {
    originals: Vec<u32>,
    local: FilePatch,
    colour: [f64; 4],
}

fn gather(rows: &Rows<'_>, patches: &[HolePatch], frame: &VertexFrame) -> Result<Vec<Piece>, Fault> {
    let mut tile_colour = None;
    let mut pieces = Vec::with_capacity(patches.len());
    for patch in patches {
        let originals = original_corners(patch);
        let stored: Vec<StoredVertex> =
            originals.iter().map(|&id| rows.vertex(id)).collect::<Result<_, Fault>>()?;
        let colour = match rows.mean_colour(stored.iter().map(|v| Ok(*v)))? {
            Some(colour) => colour,
            None if rows.colour_columns == 0 => MIDDLE_GREY,
            None => match tile_colour {
                Some(colour) => colour,
                None => *tile_colour.insert(rows.tile_colour()?.unwrap_or(MIDDLE_GREY)),
            },
        };
        let positions: Vec<DVec3> = stored.iter().map(|v| v.position).collect();
        let local = to_file_frame(patch, frame, &originals, &positions);
        pieces.push(Piece { originals, local, colour });
    }
    Ok(pieces)
}

/// Mean colour of the patches; grey where the tile has no colours. Channels up to 255 are brought to 1.
fn material_colour(rows: &Rows<'_>, pieces: &[Piece]) -> [f64; 3] {
    if rows.colour_columns == 0 || pieces.is_empty() {
        return [MIDDLE_GREY[0], MIDDLE_GREY[1], MIDDLE_GREY[2]];
    }
    let mean = [0, 1, 2].map(|k| pieces.iter().map(|p| p.colour[k]).sum::<f64>() / pieces.len() as f64);
    let full = if mean.iter().any(|&c| c > 1.0) { 255.0 } else { 1.0 };
    mean.map(|channel| (channel / full).clamp(0.0, 1.0))
}

/// At most five decimals.
fn short(value: f64) -> f64 {
    (value * 1e5).round() / 1e5 + 0.0
}

/// Statements in the making.
struct Lines {
    text: String,
    newline: &'static str,
}

impl Lines {
    fn add(&mut self, line: &str) {
        self.text.push_str(line);
        self.text.push_str(self.newline);
    }

    /// Positions as the shortest decimals that come back as the same bits.
    fn vertex(&mut self, position: DVec3, colour: &[f64]) {
        let mut line = format!("v {} {} {}", position.x, position.y, position.z);
        for channel in colour {
            line.push_str(&format!(" {}", short(*channel)));
        }
        self.add(&line);
    }

    fn normal(&mut self, normal: DVec3) {
        let [x, y, z] = normal.to_array().map(short);
        self.add(&format!("vn {x} {y} {z}"));
    }

    fn face(&mut self, triangle: &[Corner; 3], originals: &[u32], origin: Origin, has_normals: bool) {
        let mut line = String::from("f");
        for corner in triangle {
            let (vertex, slot) = match corner {
                Corner::Original(v) => (u64::from(v.0), originals.binary_search(&v.0).unwrap_or_default()),
                Corner::New(k) => (origin.vertices + u64::from(*k), originals.len() + *k as usize),
            };
            let written = match has_normals {
                true => write!(line, " {}//{}", vertex + 1, origin.normals + slot as u64 + 1),
                false => write!(line, " {}", vertex + 1),
            };
            debug_assert!(written.is_ok(), "writing to a string can't fail");
        }
        self.add(&line);
    }
}
