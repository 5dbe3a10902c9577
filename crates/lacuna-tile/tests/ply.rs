//! PLY: dialects in, patches appended, compared with an independent reader.

mod common;

use common::{Folder, files_below, new, old, patch, shared_data};
use glam::DVec3;
use lacuna_tile::{
    AppendRequest, HolePatch, NewTileRequest, NumberType, ReadOptions, ReadTile, TileError, TileFormat,
    UpAxis, append_patches, new_tile, read_header, read_tile,
};
use proptest::prelude::*;
use std::fs;
use std::path::Path;

const ENCODINGS: [&str; 3] = ["ascii", "binary_little_endian", "binary_big_endian"];

/// A PLY file in one encoding from its declarations and its rows as text (a list's values follow its count).
fn encode(encoding: &str, declarations: &str, rows: &[&str], newline: &str) -> Vec<u8> {
    let lines: Vec<&str> = declarations.lines().map(str::trim).filter(|l| !l.is_empty()).collect();
    let mut bytes = Vec::new();
    for line in
        ["ply", &format!("format {encoding} 1.0")].into_iter().chain(lines.clone()).chain(["end_header"])
    {
        bytes.extend(format!("{line}{newline}").bytes());
    }
    if encoding == "ascii" {
        rows.iter().for_each(|row| bytes.extend(format!("{row}{newline}").bytes()));
        return bytes;
    }
    let mut rows = rows.iter();
    let elements = lines.split(|l| l.starts_with("element")).skip(1);
    let counts = lines.iter().filter(|l| l.starts_with("element"));
    for (properties, element) in elements.zip(counts) {
        let count: usize = element.split(' ').nth(2).and_then(|n| n.parse().ok()).expect("count");
        for row in rows.by_ref().take(count) {
            let mut tokens = row.split_whitespace();
            for property in properties.iter().filter(|l| l.starts_with("property")) {
                encode_property(property, &mut tokens, encoding, &mut bytes);
            }
            assert_eq!(tokens.next(), None, "row {row}");
        }
    }
    bytes
}

fn encode_property<'a>(
    property: &str,
    tokens: &mut impl Iterator<Item = &'a str>,
    encoding: &str,
    bytes: &mut Vec<u8>,
) {
    let words: Vec<&str> = property.split_whitespace().collect();
    if words[1] != "list" {
        return encode_value(words[1], tokens.next().expect("value"), encoding, bytes);
    }
    let count = tokens.next().expect("count");
    encode_value(words[2], count, encoding, bytes);
    for _ in 0..count.parse::<usize>().expect("count") {
        encode_value(words[3], tokens.next().expect("value"), encoding, bytes);
    }
}

fn encode_value(kind: &str, token: &str, encoding: &str, bytes: &mut Vec<u8>) {
    let mut value = match kind {
        "char" | "int8" => token.parse::<i8>().expect(kind).to_le_bytes().to_vec(),
        "uchar" | "uint8" => token.parse::<u8>().expect(kind).to_le_bytes().to_vec(),
        "short" | "int16" => token.parse::<i16>().expect(kind).to_le_bytes().to_vec(),
        "ushort" | "uint16" => token.parse::<u16>().expect(kind).to_le_bytes().to_vec(),
        "int" | "int32" => token.parse::<i32>().expect(kind).to_le_bytes().to_vec(),
        "uint" | "uint32" => token.parse::<u32>().expect(kind).to_le_bytes().to_vec(),
        "float" | "float32" => token.parse::<f32>().expect(kind).to_le_bytes().to_vec(),
        _ => token.parse::<f64>().expect(kind).to_le_bytes().to_vec(),
    };
    if encoding == "binary_big_endian" {
        value.reverse();
    }
    bytes.extend(value);
}

fn read(path: &Path) -> Result<ReadTile, TileError> {
    read_tile(path, TileFormat::Ply, &ReadOptions::default())
}

fn append(input: &Path, output: &Path, patches: &[HolePatch]) -> Result<lacuna_tile::Written, TileError> {
    append_patches(&AppendRequest {
        input,
        output,
        format: TileFormat::Ply,
        options: &ReadOptions::default(),
        expected_hash: None,
        patches,
    })
}

struct Dialect {
    name: &'static str,
    declarations: &'static str,
    rows: &'static [&'static str],
    positions: &'static [[f64; 3]],
    triangles: &'static [[u32; 3]],
}

const SQUARE: [[f64; 3]; 4] = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.5], [0., 1., 0.]];
const TWO: [[u32; 3]; 2] = [[0, 1, 2], [0, 2, 3]];

const DIALECTS: &[Dialect] = &[
    Dialect {
        name: "plain",
        declarations: "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
            element face 2\nproperty list uchar int vertex_indices",
        rows: &["0 0 0", "1 0 0", "1 1 0.5", "0 1 0", "3 0 1 2", "3 0 2 3"],
        positions: &SQUARE,
        triangles: &TWO,
    },
    Dialect {
        name: "new names, vertex_index, a quad",
        declarations: "comment made by hand\nobj_info anything\nelement vertex 4\nproperty float64 x\nproperty float64 y\n\
            property float64 z\nelement face 1\nproperty list uint8 int32 vertex_index",
        rows: &["0 0 0", "1 0 0", "1 1 0.5", "0 1 0", "4 0 1 2 3"],
        positions: &SQUARE,
        triangles: &TWO,
    },
    Dialect {
        name: "colours, normals, other columns, lists in vertices",
        declarations: "element vertex 4\nproperty uchar flag\nproperty double x\nproperty list uchar float weights\n\
            property double y\nproperty float nx\nproperty float ny\nproperty float nz\nproperty double z\n\
            property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\n\
            element face 2\nproperty uchar quality\nproperty list ushort uint vertex_indices\nproperty list uchar float texcoord",
        rows: &[
            "7 0 0 0 0 0 1 0 10 20 30 255",
            "7 1 2 0.5 0.5 0 0 0 1 0 20 30 40 255",
            "7 1 1 1 1 0 0 1 0.5 30 40 50 255",
            "7 0 0 1 0 0 1 0 40 50 60 9",
            "1 3 0 1 2 6 0 0 1 0 1 1",
            "2 3 0 2 3 0",
        ],
        positions: &SQUARE,
        triangles: &TWO,
    },
    Dialect {
        name: "fixed rows with float colours, elements before and after, count type int",
        declarations: "element camera 1\nproperty float focus\nproperty list int short pixels\n\
            element vertex 4\nproperty float x\nproperty float y\nproperty float z\nproperty float red\nproperty float green\n\
            property float blue\nproperty float alpha\nelement edge 1\nproperty int a\nproperty int b\n\
            element face 2\nproperty list int ushort vertex_indices\nelement empty 0\nproperty int x\n\
            element note 2\nproperty list uchar uchar text",
        rows: &[
            "1.5 2 -3 4",
            "0 0 0 0.25 0 0 1",
            "1 0 0 0.75 0 0 1",
            "1 1 0.5 0.25 0 0 1",
            "0 1 0 0.75 0 0 1",
            "0 1",
            "3 0 1 2",
            "3 0 2 3",
            "2 65 66",
            "0",
        ],
        positions: &SQUARE,
        triangles: &TWO,
    },
    Dialect {
        name: "faces before vertices, short coordinates beside doubles, polygons that need ears",
        declarations: "element face 2\nproperty list char short vertex_indices\n\
            element vertex 5\nproperty double x\nproperty float y\nproperty double z",
        rows: &["4 0 1 2 3", "3 0 4 1", "0 0 0", "2 2 0", "0 1 0", "-2 2 0", "0 -1 0"],
        positions: &[[0., 0., 0.], [2., 2., 0.], [0., 1., 0.], [-2., 2., 0.], [0., -1., 0.]],
        triangles: &[[0, 1, 2], [0, 2, 3], [0, 4, 1]],
    },
    Dialect {
        name: "tristrips",
        declarations: "element vertex 5\nproperty float x\nproperty float y\nproperty float z\n\
            element tristrips 1\nproperty list int int vertex_indices",
        rows: &["0 0 0", "1 0 0", "0 1 0", "1 1 0", "0 2 0", "9 0 1 2 3 3 4 -1 0 2"],
        positions: &[[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [1., 1., 0.], [0., 2., 0.]],
        triangles: &[[0, 1, 2], [2, 1, 3]],
    },
    Dialect {
        name: "no faces at all",
        declarations: "element vertex 1\nproperty float x\nproperty float y\nproperty float z",
        rows: &["1 2 3"],
        positions: &[[1., 2., 3.]],
        triangles: &[],
    },
    Dialect {
        name: "empty",
        declarations: "element vertex 0\nproperty float x\nproperty float y\nproperty float z\n\
            element face 0\nproperty list uchar int vertex_indices",
        rows: &[],
        positions: &[],
        triangles: &[],
    },
];

/// Calls `check` with every dialect in every encoding and with both line ends.
fn each_dialect(mut check: impl FnMut(&str, &Dialect, Vec<u8>)) {
    for dialect in DIALECTS {
        for encoding in ENCODINGS {
            for (newline, newline_name) in [("\n", "LF"), ("\r\n", "CRLF")] {
                let name = format!("{}, {encoding}, {newline_name}", dialect.name);
                check(&name, dialect, encode(encoding, dialect.declarations, dialect.rows, newline));
            }
        }
    }
}

#[test]
fn dialects_read_alike_in_all_encodings() {
    let folder = Folder::new();
    each_dialect(|name, dialect, bytes| {
        let path = folder.write("tile.ply", &bytes);
        let tile = read(&path).unwrap_or_else(|e| panic!("{name}: {e}"));
        let want: Vec<DVec3> = dialect.positions.iter().map(|&p| DVec3::from(p)).collect();
        assert_eq!(tile.mesh.positions, want, "{name}");
        assert_eq!(tile.mesh.triangles, dialect.triangles, "{name}");
        assert_eq!(tile.hash, *blake3::hash(&bytes).as_bytes(), "{name}");
        assert_eq!(tile.bytes, bytes.len() as u64, "{name}");
        assert_eq!(tile.has_colour, dialect.name.contains("colours"), "{name}");
        assert_eq!(tile.warnings, Vec::<String>::new(), "{name}");
        let header = read_header(&path, TileFormat::Ply).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!(header.vertices, want.len() as u64, "{name}");
    });
}

#[test]
fn a_long_header_that_speaks_of_its_end_is_read_to_its_end() {
    let folder = Folder::new();
    let filler = "comment end_header is not yet here\n".repeat(4_000);
    let declarations = "element vertex 1\nproperty float x\nproperty float y\nproperty float z\n";
    let text = format!("ply\nformat ascii 1.0\n{filler}{declarations}end_header\n1 2 3\n");
    let path = folder.write("tile.ply", text.as_bytes());
    assert_eq!(read_header(&path, TileFormat::Ply).expect("header").vertices, 1);
    assert_eq!(read(&path).expect("tile").mesh.positions, [DVec3::new(1.0, 2.0, 3.0)]);
}

#[test]
fn strips_turn_every_second_triangle_and_skip_joins() {
    let dialect = &DIALECTS[5];
    let folder = Folder::new();
    let path = folder.write("tile.ply", encode("ascii", dialect.declarations, dialect.rows, "\n"));
    // 0 1 2 3 3 4 -1 0 2: the joins 2 3 3 and 3 3 4 have no surface, the second strip is too short
    assert_eq!(read(&path).expect("tile").mesh.triangles, [[0, 1, 2], [2, 1, 3]]);
    let rows = ["0 0 0", "1 0 0", "0 1 0", "1 1 0", "0 2 0", "9 0 1 2 3 4 -1 2 1 3"];
    let path = folder.write("tile.ply", encode("ascii", dialect.declarations, &rows, "\n"));
    assert_eq!(read(&path).expect("tile").mesh.triangles, [[0, 1, 2], [2, 1, 3], [2, 3, 4], [2, 1, 3]]);
}

/// The body of a file and its rows by element, found without the crate's own parser.
fn body(bytes: &[u8]) -> &[u8] {
    let marker = b"end_header";
    let start = bytes.windows(marker.len()).position(|w| w == marker).expect("end_header");
    let end = bytes[start..].iter().position(|&b| b == b'\n').expect("line end");
    &bytes[start + end + 1..]
}

fn header_lines(bytes: &[u8]) -> Vec<String> {
    let header = &bytes[..bytes.len() - body(bytes).len()];
    String::from_utf8_lossy(header).lines().map(str::to_owned).collect()
}

#[test]
fn patches_go_behind_the_originals_in_every_dialect() {
    let folder = Folder::new();
    each_dialect(|name, dialect, bytes| {
        let (input, output) = (folder.write("in.ply", &bytes), folder.path("out.ply"));
        let before = read(&input).expect(name);
        let n = before.mesh.positions.len() as u32;
        let triangles =
            if n >= 3 { vec![[old(0), old(n - 1), new(1)], [old(1), new(0), new(1)]] } else { vec![] };
        let points = [[0.1, 0.2, 0.3], [4.0, 5.0, 1e-3]].map(DVec3::from).map(|p| before.frame.round(p));
        let one = patch("h1", &points.map(|p| p.to_array()), &triangles);
        let two = patch("h\n2", &[], &[]);
        let written = append(&input, &output, &[one, two]).unwrap_or_else(|e| panic!("{name}: {e}"));
        let after_bytes = fs::read(&output).expect(name);
        assert_eq!(written.bytes, after_bytes.len() as u64, "{name}");
        assert_eq!(written.hash, *blake3::hash(&after_bytes).as_bytes(), "{name}");
        let after = read(&output).unwrap_or_else(|e| panic!("{name}: {e}"));
        let want: Vec<DVec3> = before.mesh.positions.iter().copied().chain(points).collect();
        assert_eq!(after.mesh.positions, want, "{name}");
        let mut want = before.mesh.triangles.clone();
        want.extend(if n >= 3 { vec![[0, n - 1, n + 1], [1, n, n + 1]] } else { vec![] });
        assert_eq!(after.mesh.triangles, want, "{name}");
        assert_eq!(after.warnings, Vec::<String>::new(), "{name}");
        check_bytes(name, dialect, &bytes, &after_bytes);
    });
}

/// Taking the patch's rows and header changes away again gives the original.
fn check_bytes(name: &str, dialect: &Dialect, before: &[u8], after: &[u8]) {
    let added: Vec<String> = header_lines(after).into_iter().filter(|l| l.contains("lacuna patch")).collect();
    let faces = dialect.declarations.lines().find_map(|l| l.strip_prefix("element face "));
    let first_face: usize = faces.map_or(0, |n| n.parse().expect("count"));
    let n = dialect.positions.len();
    let range = if n >= 3 { format!("{first_face}..{}", first_face + 1) } else { "none".to_owned() };
    assert_eq!(
        added[0],
        format!("comment lacuna patch: vertices {n}..{} faces {range} hole h1", n + 1),
        "{name}"
    );
    assert_eq!(added[1], "comment lacuna patch: vertices none faces none hole h_2", "{name}");
    let kept: Vec<String> = header_lines(after).into_iter().filter(|l| !l.contains("lacuna patch")).collect();
    let stripped = |lines: &[String]| -> Vec<String> {
        let is_count = |l: &&String| !l.starts_with("element vertex") && !l.starts_with("element face");
        lines.iter().filter(is_count).cloned().collect()
    };
    let mut want = stripped(&header_lines(before));
    if faces.is_none() {
        want.insert(want.len() - 1, "property list uchar int vertex_indices".to_owned());
    }
    assert_eq!(stripped(&kept), want, "{name}");
    assert_subsequence(name, body(before), body(after));
}

/// Every original byte comes out in order: the new body is the old one with two runs put in.
fn assert_subsequence(name: &str, before: &[u8], after: &[u8]) {
    let front = before.iter().zip(after).take_while(|(a, b)| a == b).count();
    let back = before.iter().rev().zip(after.iter().rev()).take_while(|(a, b)| a == b).count();
    if front + back >= before.len() {
        return;
    }
    let middle = &before[front..before.len() - back];
    let inside = &after[front..after.len() - back];
    assert!(
        inside.windows(middle.len()).any(|w| w == middle),
        "{name}: the rows between the runs are not there"
    );
}

#[test]
fn patch_rows_have_a_value_for_every_property() {
    let dialect = &DIALECTS[2];
    let folder = Folder::new();
    let input = folder.write("in.ply", encode("ascii", dialect.declarations, dialect.rows, "\n"));
    let level = patch("h", &[[0.5, 0.5, 0.0]], &[[old(0), old(1), new(0)], [old(3), old(0), new(0)]]);
    append(&input, &folder.path("out.ply"), &[level]).expect("append");
    let text = fs::read_to_string(folder.path("out.ply")).expect("text");
    let rows: Vec<&str> = text.lines().skip_while(|l| *l != "end_header").skip(1).collect();
    // flag 0, no weights, normal up, mean of rows 0, 1 and 3: 70/3, 100/3, 130/3
    assert_eq!(rows[4], "0 0.5 0 0.5 0 0 1 0 23 33 43 255");
    assert_eq!(rows[7..], ["0 3 0 1 4 0", "0 3 3 0 4 0"]);
    let dialect = &DIALECTS[3];
    let input = folder.write("in.ply", encode("ascii", dialect.declarations, dialect.rows, "\n"));
    let free = patch("h", &[[1.5, 0.1, 0.0]], &[]);
    append(&input, &folder.path("out.ply"), &[free]).expect("append");
    let text = fs::read_to_string(folder.path("out.ply")).expect("text");
    assert!(text.contains("\n1.5 0.1 0 0.5 0 0 1\n"), "without a rim the tile's mean colour: {text}");
}

#[test]
fn text_without_a_last_line_end_gets_one() {
    let folder = Folder::new();
    for (index, rows) in [(0, 6), (6, 1)] {
        let dialect = &DIALECTS[index];
        let mut bytes = encode("ascii", dialect.declarations, dialect.rows, "\n");
        bytes.pop();
        let input = folder.write("in.ply", &bytes);
        append(&input, &folder.path("out.ply"), &[patch("h", &[[7., 8., 9.]], &[])]).expect("append");
        let tile = read(&folder.path("out.ply")).expect("tile");
        assert_eq!(tile.mesh.positions.last(), Some(&DVec3::new(7., 8., 9.)));
        let text = fs::read(folder.path("out.ply")).expect("text");
        let lines = String::from_utf8_lossy(body(&text)).lines().count();
        assert_eq!(lines, rows + 1, "no blank lines");
    }
}

#[test]
fn index_types_that_are_too_small_are_refused() {
    let folder = Folder::new();
    let declare = |kind: &str, count: usize| {
        format!(
            "element vertex {count}\nproperty float x\nproperty float y\nproperty float z\n\
             element face 1\nproperty list uchar {kind} vertex_indices"
        )
    };
    for (kind, count, added, want) in [
        ("uchar", 254, 2, None),
        ("uchar", 255, 2, Some((255, 256))),
        ("char", 127, 2, Some((127, 128))),
        ("short", 32_766, 2, None),
        ("short", 32_767, 2, Some((32_767, 32_768))),
        ("ushort", 65_535, 2, Some((65_535, 65_536))),
        ("int", 65_535, 2, None),
    ] {
        let mut rows = vec!["0 0 0"; count];
        rows.push("3 0 1 2");
        let input =
            folder.write("in.ply", encode("binary_little_endian", &declare(kind, count), &rows, "\n"));
        let triangle = [old(0), new(0), new(1)];
        let request = patch("h", &vec![[0.0; 3]; added], &[triangle]);
        let got = append(&input, &folder.path("out.ply"), &[request]);
        match (got, want) {
            (Ok(_), None) => {
                let last = read(&folder.path("out.ply")).expect("tile").mesh.triangles[1];
                assert_eq!(last, [0, count as u32, count as u32 + 1], "{kind}");
            }
            (Err(TileError::IndexTypeTooSmall { largest, needed, index_type, .. }), Some(numbers)) => {
                assert_eq!((largest, needed, index_type.as_str()), (numbers.0, numbers.1, kind));
            }
            (got, want) => panic!("{kind} {count}: {got:?}, not {want:?}"),
        }
    }
}

#[test]
fn the_frame_turns_and_rounds() {
    let folder = Folder::new();
    let dialect = &DIALECTS[0];
    let input = folder.write("in.ply", encode("binary_big_endian", dialect.declarations, dialect.rows, "\n"));
    let options = ReadOptions { up_axis: Some(UpAxis::Y), ..ReadOptions::default() };
    let before = read_tile(&input, TileFormat::Ply, &options).expect("tile");
    assert_eq!(before.mesh.positions[2], DVec3::new(1.0, -0.5, 1.0), "(x, -z, y)");
    assert_eq!(before.frame.number, NumberType::F32);
    let rounded = before.frame.round(DVec3::new(0.1, 0.7, 0.3));
    assert_eq!(rounded, DVec3::new(f64::from(0.1_f32), f64::from(0.7_f32), f64::from(0.3_f32)));
    let output = folder.path("out.ply");
    let patches = [patch("h", &[rounded.to_array()], &[[old(0), old(1), new(0)]])];
    let request = AppendRequest {
        input: &input,
        output: &output,
        format: TileFormat::Ply,
        options: &options,
        expected_hash: Some(before.hash),
        patches: &patches,
    };
    append_patches(&request).expect("append");
    let after = read_tile(&output, TileFormat::Ply, &options).expect("tile");
    assert_eq!(after.mesh.positions[4], rounded);
    assert_eq!(before.frame.round(rounded), rounded, "rounding twice is rounding once");
    fs::write(&input, "ply\n").expect("write");
    assert!(matches!(append_patches(&request), Err(TileError::InputChanged { .. })));
}

#[test]
fn no_patches_are_the_same_bytes() {
    let folder = Folder::new();
    each_dialect(|name, _, bytes| {
        let input = folder.write("in.ply", &bytes);
        let written = append(&input, &folder.path("out.ply"), &[]).expect(name);
        assert_eq!(fs::read(folder.path("out.ply")).expect(name), bytes, "{name}");
        assert_eq!(written.hash, *blake3::hash(&bytes).as_bytes(), "{name}");
    });
}

#[test]
fn new_tiles_take_over_the_template() {
    let folder = Folder::new();
    each_dialect(|name, dialect, bytes| {
        let (template, output) = (folder.write("in.ply", &bytes), folder.path("new.ply"));
        let corners = [[0., 0., 1.], [1., 0., 1.], [0., 1., 1.]];
        let patches = [
            patch("h1", &corners, &[[new(0), new(1), new(2)]]),
            patch("h2", &corners, &[[new(2), new(0), new(1)]]),
        ];
        let options = ReadOptions::default();
        let request = NewTileRequest {
            template: &template,
            output: &output,
            format: TileFormat::Ply,
            options: &options,
            patches: &patches,
        };
        new_tile(&request).unwrap_or_else(|e| panic!("{name}: {e}"));
        let tile = read(&output).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!(
            tile.mesh.positions,
            corners.iter().chain(&corners).map(|&c| DVec3::from(c)).collect::<Vec<_>>()
        );
        assert_eq!(tile.mesh.triangles, [[0, 1, 2], [5, 3, 4]], "{name}");
        let properties = |bytes: &[u8]| -> Vec<String> {
            header_lines(bytes)
                .into_iter()
                .filter(|l| l.starts_with("property") || l.starts_with("format"))
                .collect()
        };
        let (mut want, got) = (properties(&bytes), properties(&fs::read(&output).expect(name)));
        want.extend(
            (!dialect.declarations.contains("face"))
                .then(|| "property list uchar int vertex_indices".to_owned()),
        );
        assert_eq!(got, want, "{name}");
        let wrong = [patch("h", &[[0.; 3]; 2], &[[old(0), new(0), new(1)]])];
        assert!(matches!(
            new_tile(&NewTileRequest { patches: &wrong, ..request }),
            Err(TileError::BadPatch { .. })
        ));
    });
}

#[test]
fn a_new_tile_does_not_speak_of_the_templates_rows() {
    let folder = Folder::new();
    let declarations = "comment by a survey\ncomment TextureFile a b.jpg\nelement vertex 1\nproperty float x\nproperty float y\n\
        property float z\nelement face 0\nproperty list uchar int vertex_indices\n\
        comment lacuna patch: vertices 0..0 faces none hole old";
    let template = folder.write("in.ply", encode("ascii", declarations, &["0 0 0"], "\n"));
    assert_eq!(read(&template).expect("tile").textures, ["a b.jpg"]);
    let options = ReadOptions::default();
    let output = folder.path("new.ply");
    new_tile(&NewTileRequest {
        template: &template,
        output: &output,
        format: TileFormat::Ply,
        options: &options,
        patches: &[],
    })
    .expect("new tile");
    assert_eq!(
        fs::read_to_string(&output).expect("text"),
        "ply\nformat ascii 1.0\ncomment by a survey\nelement vertex 0\nproperty float x\nproperty float y\nproperty float z\n\
         element face 0\nproperty list uchar int vertex_indices\nend_header\n"
    );
}

/// Positions and corner lists as ply-rs-bw reads them.
fn oracle(path: &Path) -> Option<(Vec<[f64; 3]>, Vec<Vec<i64>>)> {
    use ply_rs_bw::parser::Parser;
    use ply_rs_bw::ply::{DefaultElement, Property};
    let number = |p: &Property| match *p {
        Property::Char(v) => f64::from(v),
        Property::UChar(v) => f64::from(v),
        Property::Short(v) => f64::from(v),
        Property::UShort(v) => f64::from(v),
        Property::Int(v) => f64::from(v),
        Property::UInt(v) => f64::from(v),
        Property::Float(v) => f64::from(v),
        Property::Double(v) => v,
        _ => f64::NAN,
    };
    let indices = |p: &Property| -> Vec<i64> {
        match p {
            Property::ListChar(v) => v.iter().map(|&x| x.into()).collect(),
            Property::ListUChar(v) => v.iter().map(|&x| x.into()).collect(),
            Property::ListShort(v) => v.iter().map(|&x| x.into()).collect(),
            Property::ListUShort(v) => v.iter().map(|&x| x.into()).collect(),
            Property::ListInt(v) => v.iter().map(|&x| x.into()).collect(),
            Property::ListUInt(v) => v.iter().map(|&x| x.into()).collect(),
            _ => Vec::new(),
        }
    };
    let mut file = std::io::BufReader::new(fs::File::open(path).ok()?);
    let ply = Parser::<DefaultElement>::new().read_ply(&mut file).ok()?;
    let vertices = ply.payload.get("vertex")?;
    let positions = vertices
        .iter()
        .map(|v| Some([number(v.get("x")?), number(v.get("y")?), number(v.get("z")?)]))
        .collect::<Option<Vec<_>>>()?;
    let faces = ply.payload.get("face").map_or(&[][..], |f| &f[..]);
    let lists = faces
        .iter()
        .map(|f| f.get("vertex_indices").or_else(|| f.get("vertex_index")).map_or_else(Vec::new, indices));
    Some((positions, lists.collect()))
}

/// Compares our reading with the oracle's; false if the oracle finds no mesh.
fn agrees_with_oracle(path: &Path) -> bool {
    let Some((positions, faces)) = oracle(path) else { return false };
    let tile = read(path).unwrap_or_else(|e| panic!("the oracle reads what we do not: {e}"));
    assert_eq!(
        tile.mesh.positions,
        positions.into_iter().map(DVec3::from).collect::<Vec<_>>(),
        "{}",
        path.display()
    );
    let want: usize = faces.iter().map(|f| f.len().saturating_sub(2)).sum();
    assert_eq!(tile.mesh.triangles.len(), want, "{}", path.display());
    let mut triangles = tile.mesh.triangles.iter();
    for face in &faces {
        let mine: Vec<_> = triangles.by_ref().take(face.len() - 2).flatten().map(|&v| i64::from(v)).collect();
        let sorted = |mut v: Vec<i64>| {
            v.sort_unstable();
            v.dedup();
            v
        };
        assert_eq!(sorted(mine), sorted(face.clone()), "{}", path.display());
    }
    true
}

#[test]
fn real_files_agree_with_ply_rs_bw() {
    let folders =
        ["ply-rs-bw-examples", "assimp-testmodels/PLY", "pymeshfix-examples", "ahn3-delft/tiles_dsm_50m"];
    for (folder, least) in folders.into_iter().zip([7, 4, 1, 20]) {
        let Some(root) = shared_data(folder) else { continue };
        let compared = files_below(&root, "ply").iter().filter(|path| agrees_with_oracle(path)).count();
        assert!(compared >= least, "{folder}: {compared} files compared");
    }
}

#[test]
fn repaired_real_files_agree_with_ply_rs_bw() {
    let Some(root) = shared_data("ahn3-delft/tiles_dsm_50m") else { return };
    let folder = Folder::new();
    for path in files_below(&root, "ply").iter().take(5) {
        let before = read(path).expect("tile");
        let n = before.mesh.positions.len() as u32;
        let centre = before.frame.round(before.mesh.positions[0] + DVec3::ONE);
        let patches =
            [patch("h", &[centre.to_array()], &[[old(0), old(1), new(0)], [old(n - 1), new(0), old(2)]])];
        append(path, &folder.path("out.ply"), &patches).expect("append");
        assert!(agrees_with_oracle(&folder.path("out.ply")));
        let after = read(&folder.path("out.ply")).expect("tile");
        assert_eq!(after.mesh.positions[n as usize], centre);
        assert_eq!(after.mesh.triangles[before.mesh.triangles.len()..], [[0, 1, n], [n - 1, n, 2]]);
        assert_subsequence(
            "real",
            body(&fs::read(path).expect("in")),
            body(&fs::read(folder.path("out.ply")).expect("out")),
        );
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_mesh_comes_back_with_its_patch(
        points in prop::collection::vec(prop::array::uniform3(-1e7..1e7_f64), 3..40),
        picks in prop::collection::vec(prop::array::uniform3(0_usize..1000), 0..40),
        added in prop::collection::vec(prop::array::uniform3(-1e7..1e7_f64), 1..10),
        encoding in 0_usize..3,
        number in prop::sample::select(vec!["float", "double"]),
    ) {
        let declarations = format!(
            "element vertex {}\nproperty {number} x\nproperty {number} y\nproperty {number} z\n\
             element face {}\nproperty list uchar int vertex_indices", points.len(), picks.len());
        let n = points.len();
        let rows: Vec<String> = points.iter().map(|p| format!("{} {} {}", p[0], p[1], p[2]))
            .chain(picks.iter().map(|t| format!("3 {} {} {}", t[0] % n, t[1] % n, t[2] % n))).collect();
        let rows: Vec<&str> = rows.iter().map(String::as_str).collect();
        let folder = Folder::new();
        let input = folder.write("in.ply", encode(ENCODINGS[encoding], &declarations, &rows, "\n"));
        let before = read(&input).expect("tile");
        let exact: Vec<DVec3> = points.iter().map(|&p| before.frame.round(DVec3::from(p))).collect();
        prop_assert_eq!(&before.mesh.positions, &exact);
        let rounded: Vec<[f64; 3]> = added.iter().map(|&p| before.frame.round(DVec3::from(p)).to_array()).collect();
        append(&input, &folder.path("out.ply"), &[patch("h", &rounded, &[[old(0), old(1), new(0)]])]).expect("append");
        let after = read(&folder.path("out.ply")).expect("tile");
        prop_assert_eq!(&after.mesh.positions[..n], &exact[..]);
        let want: Vec<DVec3> = rounded.into_iter().map(DVec3::from).collect();
        prop_assert_eq!(&after.mesh.positions[n..], &want[..]);
        prop_assert_eq!(&after.mesh.triangles[..picks.len()], &before.mesh.triangles[..]);
        prop_assert_eq!(after.mesh.triangles[picks.len()], [0, 1, n as u32]);
    }
}
