//! Broken and hostile PLY and OBJ files: one typed error each, no panic, no hang, no large allocation.

mod common;

use common::{Folder, new, old, patch, without_folder};
use lacuna_tile::{
    AppendRequest, HolePatch, ReadOptions, TileError, TileFormat, append_patches, read_header, read_tile,
};
use std::time::{Duration, Instant};

const LIMIT: Duration = Duration::from_secs(5); // a debug machine under load; the aim is 1 s

/// Reads, reads the header, appends: all three must come back in time. Returns what reading says, without the folder.
fn outcome(name: &str, format: TileFormat, bytes: &[u8]) -> String {
    let folder = Folder::new();
    let path = folder.write("tile", bytes);
    let start = Instant::now();
    let options = ReadOptions::default();
    let result = read_tile(&path, format, &options);
    let header = read_header(&path, format);
    let patches = [patch("h", &[[0.5, 0.5, 0.5]], &[[old(0), old(1), new(0)]])];
    let output = folder.path("out");
    let request = AppendRequest {
        input: &path,
        output: &output,
        format,
        options: &options,
        expected_hash: None,
        patches: &patches,
    };
    let appended = append_patches(&request);
    assert!(start.elapsed() < LIMIT, "{name}: {:?}", start.elapsed());
    assert!(appended.is_ok() || !output.exists(), "{name}: an output after {appended:?}");
    assert!(header.is_ok() || result.is_err(), "{name}: a bad header of a good tile: {header:?}");
    // What a job is lent follows from these counts.
    let promised = header.map_or(0, |h| h.vertices.max(h.triangles));
    assert!(promised <= bytes.len() as u64 + 1, "{name}: {promised} promised by {} bytes", bytes.len());
    match result {
        Ok(tile) => {
            let (v, t) = (tile.mesh.positions.len(), tile.mesh.triangles.len());
            assert!(tile.mesh.triangles.iter().flatten().all(|&i| (i as usize) < v), "{name}");
            format!("ok {v} {t} {}", tile.warnings.join("; "))
        }
        Err(error) => without_folder(&error.to_string(), &folder),
    }
}

fn check(format: TileFormat, cases: &[(&str, Vec<u8>, &str)]) {
    for (name, bytes, want) in cases {
        let got = outcome(name, format, bytes);
        assert!(got.starts_with(want), "{name}:\n got {got}\nwant {want}");
    }
}

/// A PLY header in this encoding.
fn ply(encoding: &str, declarations: &str) -> Vec<u8> {
    format!("ply\nformat {encoding} 1.0\n{declarations}end_header\n").into_bytes()
}

const XYZ: &str = "property float x\nproperty float y\nproperty float z\n";
const FACE: &str = "property list uchar int vertex_indices\n";

fn with(mut header: Vec<u8>, body: &[u8]) -> Vec<u8> {
    header.extend(body);
    header
}

/// A binary triangle file whose face row is given.
fn triangle(face_property: &str, face_row: &[u8]) -> Vec<u8> {
    let declarations = format!("element vertex 3\n{XYZ}element face 1\n{face_property}");
    let corners: Vec<u8> =
        [0.0_f32, 0., 0., 1., 0., 0., 0., 1., 0.].iter().flat_map(|x| x.to_le_bytes()).collect();
    with(with(ply("binary_little_endian", &declarations), &corners), face_row)
}

fn row(values: &[i32]) -> Vec<u8> {
    let mut row = vec![values.len() as u8];
    values.iter().for_each(|v| row.extend(v.to_le_bytes()));
    row
}

#[test]
fn ply_headers() {
    let ascii = |declarations: &str| ply("ascii", declarations);
    let digits = "9".repeat(40);
    let cases: Vec<(&str, Vec<u8>, &str)> = vec![
        ("empty", vec![], "tile: byte 0: the file does not start with `ply`; export the tile again"),
        ("magic alone", b"ply".to_vec(), "tile: byte 0: the file does not start"),
        ("another format", b"solid x\n".to_vec(), "tile: byte 0: the file does not start"),
        (
            "line ends of CR",
            b"ply\rformat ascii 1.0\rend_header\r".to_vec(),
            "tile: line 1: not supported: header lines end in CR",
        ),
        (
            "no end_header",
            b"ply\nformat ascii 1.0\nelement vertex 1\n".to_vec(),
            "tile: line 4: the header has no `end_header` line",
        ),
        (
            "no format",
            b"ply\nelement vertex 0\nend_header\n".to_vec(),
            "tile: line 3: the header has no format line",
        ),
        ("unknown format", ply("binary_middle_endian", ""), "tile: line 2: header: the format must be"),
        ("two formats", ascii("format ascii 1.0\n"), "tile: line 3: header: there are two format lines"),
        ("unknown keyword", ascii("elephant 1\n"), "tile: line 3: header: this keyword is not known"),
        (
            "40 digits",
            ascii(&format!("element vertex {digits}\n")),
            "tile: line 3: header: the count is no whole number",
        ),
        (
            "negative count",
            ascii("element vertex -1\n"),
            "tile: line 3: header: the count is no whole number",
        ),
        ("no count", ascii("element vertex\n"), "tile: line 3: header: an element has a name and a count"),
        (
            "two vertex elements",
            ascii(&format!("element vertex 0\n{XYZ}element vertex 0\n")),
            "tile: line 7: header: there are two elements",
        ),
        (
            "two properties x",
            ascii("element vertex 0\nproperty float x\nproperty float x\n"),
            "tile: line 5: header: the element has two properties",
        ),
        (
            "property first",
            ascii("property float x\n"),
            "tile: line 3: header: a property stands before any element",
        ),
        (
            "unknown type",
            ascii("element vertex 0\nproperty int128 x\n"),
            "tile: line 4: not supported: header: number type `int128`",
        ),
        (
            "escape codes",
            ascii("element vertex 0\nproperty \u{1b}[31m x\n"),
            "tile: line 4: not supported: header: number type `\\u{1b}[31m`",
        ),
        (
            "list count of floats",
            ascii("element face 0\nproperty list float int vertex_indices\n"),
            "tile: line 4: header: a list's count",
        ),
        (
            "no vertices",
            ascii(&format!("element face 0\n{FACE}")),
            "tile: the file as a whole: the header declares no element `vertex`",
        ),
        (
            "no z",
            ascii("element vertex 0\nproperty float x\nproperty float y\n"),
            "tile: line 3: `vertex` has no property `z`",
        ),
        (
            "x is a list",
            ascii("element vertex 0\nproperty list uchar float x\nproperty float y\nproperty float z\n"),
            "tile: line 4: the coordinate `x` is a list",
        ),
        (
            "faces without indices",
            ascii(&format!("element vertex 0\n{XYZ}element face 0\nproperty int material\n")),
            "tile: line 7: `face` has no list `vertex_indices`",
        ),
        (
            "no text",
            b"ply\nformat ascii 1.0\nelement \xff\xfe 0\nend_header\n".to_vec(),
            "tile: line 3: header: it is no text",
        ),
    ];
    check(TileFormat::Ply, &cases);
}

#[test]
fn ply_bodies() {
    let huge = |encoding: &str, count: u64, name: &str| {
        let vertex =
            format!("element {name} {count}\n{}", if name == "vertex" { XYZ } else { "property int a\n" });
        let rest = if name == "vertex" { String::new() } else { format!("element vertex 0\n{XYZ}") };
        ply(encoding, &format!("{vertex}{rest}"))
    };
    let binary = |declarations: &str, body: &[u8]| with(ply("binary_little_endian", declarations), body);
    let promise = "tile: line 3: the header promises";
    let wide_list = "property list uint int vertex_indices\n";
    let signed_list = "property list int int vertex_indices\n";
    let cases: Vec<(&str, Vec<u8>, &str)> = vec![
        (
            "10^12 vertices",
            huge("binary_little_endian", 1_000_000_000_000, "vertex"),
            "tile: line 3: not supported: 1000000000000 vertices",
        ),
        ("2^40 rows, ascii", huge("ascii", 1 << 40, "other"), promise),
        ("2^40 rows, binary", huge("binary_big_endian", 1 << 40, "other"), promise),
        ("2^63 rows", huge("binary_little_endian", 1 << 63, "other"), promise),
        ("2^32 - 2 vertices", huge("binary_little_endian", u64::from(u32::MAX) - 1, "vertex"), promise),
        (
            "2^60 rows of nothing",
            with(ply("ascii", &format!("element void {}\nelement vertex 1\n{XYZ}", 1_u64 << 60)), b"1 2 3\n"),
            "ok 1 0",
        ),
        (
            "2^40 faces",
            binary(&format!("element vertex 0\n{XYZ}element face {}\n{FACE}", 1_u64 << 40), b""),
            "tile: line 7: the header promises",
        ),
        (
            "list of 2^32 - 1",
            triangle(wide_list, &[0xff; 16]),
            "tile: byte 208: a list of 4294967295 values, at most 3 are left",
        ),
        ("list of -1", triangle(signed_list, &[0xff; 16]), "tile: byte 207: a list of -1 values"),
        (
            "index = vertex count",
            triangle(FACE, &row(&[0, 1, 3])),
            "tile: face row 0: vertex [0, 1, 3], but there are 3 vertices",
        ),
        ("index -1", triangle(FACE, &row(&[0, 1, -1])), "tile: face row 0: vertex [0, 1, 4294967295]"),
        (
            "index in a polygon",
            triangle(FACE, &row(&[0, 1, 2, 9])),
            "tile: face row 0: vertex 9.0, but there are 3 vertices",
        ),
        (
            "fractional index",
            triangle(
                "property list uchar float vertex_indices\n",
                &[vec![3], [0.0_f32, 1.0, 1.5].iter().flat_map(|x| x.to_le_bytes()).collect()].concat(),
            ),
            "tile: face row 0: vertex 1.5",
        ),
        (
            "NaN as index",
            triangle(
                "property list uchar float vertex_indices\n",
                &[vec![3], [0.0_f32, 1.0, f32::NAN].iter().flat_map(|x| x.to_le_bytes()).collect()].concat(),
            ),
            "tile: face row 0: vertex NaN",
        ),
        ("short faces", triangle(FACE, &row(&[0, 1])), "ok 3 0 1 faces with fewer than three corners"),
        (
            "bytes behind the end",
            triangle(FACE, &[row(&[0, 1, 2]), vec![1, 2, 3]].concat()),
            "ok 3 1 3 bytes after the last element",
        ),
        (
            "a word for a number",
            with(ply("ascii", &format!("element vertex 1\n{XYZ}")), b"1 two 3\n"),
            "tile: line 8: `two` is no number",
        ),
        (
            "a row too short",
            with(ply("ascii", &format!("element vertex 2\n{XYZ}")), b"1 2\n3 4 5 6\n"),
            "tile: line 8: the row has too few values",
        ),
        (
            "a row too long",
            with(ply("ascii", &format!("element vertex 1\n{XYZ}")), b"1 2 3 4\n"),
            "ok 1 0 1 rows with more values",
        ),
        (
            "NaN rows",
            with(
                ply("ascii", &format!("element vertex 4\n{XYZ}element face 2\n{FACE}")),
                b"nan 0 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n3 1 2 3\n",
            ),
            "ok 4 1 1 vertices are not finite; 1 triangles that touch them are left out",
        ),
    ];
    check(TileFormat::Ply, &cases);
}

#[test]
fn obj_files() {
    let unit = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    let text = |tail: &str| format!("{unit}{tail}").into_bytes();
    let large_face = || {
        let mut text = format!("{unit}f");
        (0..1_000_000).for_each(|k| text += [" 1", " 2", " 3"][k % 3]);
        text.into_bytes()
    };
    let utf16 = |big: bool| -> Vec<u8> {
        let bytes = |u: u16| if big { u.to_be_bytes() } else { u.to_le_bytes() };
        "\u{feff}v 0 0 0\n".encode_utf16().flat_map(bytes).collect()
    };
    let cases: Vec<(&str, Vec<u8>, &str)> = vec![
        (
            "f -99",
            text("f -99 1 2\n"),
            "tile: line 4: index -99, but 3 vertices stand above; export the tile again",
        ),
        ("f 2^32", text("f 1 2 4294967296\n"), "tile: line 4: index 4294967296, but the file has 3 vertices"),
        ("f 2^32 + 1", text("f 1 2 4294967297\n"), "tile: line 4: index 4294967297"),
        ("f of 60 digits", text(&format!("f 1 2 {}\n", "9".repeat(60))), "tile: line 4: index 8589934592"),
        ("f -(60 digits)", text(&format!("f 1 2 -{}\n", "9".repeat(60))), "tile: line 4: index -8589934592"),
        ("f 0", text("f 0 1 2\n"), "tile: line 4: index 0: OBJ counts from 1"),
        (
            "index = count + 1",
            text("# c\nf 1 2 4\nf 1 2 3\n"),
            "tile: line 5: index 4, but the file has 3 vertices",
        ),
        ("polygon out of range", text("f 1 2 3 4\n"), "tile: line 4: index 4, but the file has 3 vertices"),
        ("f without digits", text("f a b c\n"), "tile: line 4: this is no vertex index"),
        ("f 1.5", text("f 1.5 2 3\n"), "tile: line 4: this is no vertex index"),
        ("f -", text("f - 2 3\n"), "tile: line 4: this is no vertex index"),
        ("f /1", text("f /1 2 3\n"), "tile: line 4: this is no vertex index"),
        ("two numbers", text("v 1 2\n"), "tile: line 4: a vertex needs three numbers"),
        ("no numbers", text("v\n"), "tile: line 4: a vertex needs three numbers"),
        ("words", text("v a b c\n"), "tile: line 4: this is no number"),
        (
            "nan inf 1e999",
            text("v nan inf 1e999\nf 1 2 4\n"),
            "ok 4 0 1 vertices are not finite; 1 triangles",
        ),
        ("a face of 10^6 corners", large_face(), "ok 3 999998"),
        (
            "UTF-16 big",
            utf16(true),
            "tile: byte 0: not supported: UTF-16 text; save the file as UTF-8 or ASCII",
        ),
        ("UTF-16 little", utf16(false), "tile: byte 0: not supported: UTF-16 text"),
        ("UTF-16 without a mark", b"v\0 \x000\0".to_vec(), "tile: byte 0: not supported: UTF-16 text"),
        ("a library that is the file", text("mtllib tile\nmtllib /etc/passwd\nf 1 2 3\n"), "ok 3 1"),
        ("binary rubbish", (0..=255).cycle().skip(1).take(10_000).collect(), "ok 0 0"),
        ("backslashes", vec![b'\\'; 100_000], "ok 0 0"),
        ("a thousand digits", format!("v 0.{} 1 2\n", "1".repeat(1_000_000)).into_bytes(), "ok 1 0"),
    ];
    check(TileFormat::Obj, &cases);
}

/// A file cut at each sixteenth ends in one typed error or in a smaller mesh, never in a panic.
#[test]
fn truncated_files() {
    let vertices = 40;
    let ring: Vec<[f32; 3]> = (0..vertices).map(|k| [k as f32, (k * k % 7) as f32, 0.5]).collect();
    let faces: Vec<[i32; 3]> = (0..vertices - 2).map(|k| [k, k + 1, k + 2]).collect();
    let declarations = format!("element vertex {vertices}\n{XYZ}element face {}\n{FACE}", faces.len());
    let mut binary = ply("binary_little_endian", &declarations);
    ring.iter().flatten().for_each(|x| binary.extend(x.to_le_bytes()));
    faces.iter().for_each(|f| binary.extend(row(f)));
    let mut ascii = ply("ascii", &declarations);
    ring.iter().for_each(|[x, y, z]| ascii.extend(format!("{x} {y} {z}\n").bytes()));
    faces.iter().for_each(|[a, b, c]| ascii.extend(format!("3 {a} {b} {c}\n").bytes()));
    let mut obj = Vec::new();
    ring.iter().for_each(|[x, y, z]| obj.extend(format!("v {x} {y} {z}\n").bytes()));
    faces.iter().for_each(|[a, b, c]| obj.extend(format!("f {} {} {}\n", a + 1, b + 1, c + 1).bytes()));
    for (format, whole) in [(TileFormat::Ply, binary), (TileFormat::Ply, ascii), (TileFormat::Obj, obj)] {
        for sixteenth in 0..=16 {
            let length = whole.len() * sixteenth / 16;
            let got = outcome(&format!("{format:?} {sixteenth}/16"), format, &whole[..length]);
            match (format, sixteenth) {
                (_, 16) => assert!(got.starts_with("ok 40 38"), "{got}"),
                (TileFormat::Ply, _) => assert!(got.starts_with("tile: "), "{sixteenth}/16: {got}"),
                _ => {
                    assert!(got.starts_with("ok ") || got.starts_with("tile: line"), "{sixteenth}/16: {got}")
                }
            }
        }
    }
}

/// Every single byte set to some odd values: no panic, and indices stay in range.
#[test]
fn damaged_bytes() {
    let ascii = with(
        ply("ascii", &format!("element vertex 3\n{XYZ}element face 1\n{FACE}")),
        b"0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
    );
    let files = [
        (TileFormat::Ply, ascii),
        (TileFormat::Ply, triangle(FACE, &row(&[0, 1, 2]))),
        (
            TileFormat::Obj,
            b"mtllib a\nv 0 0 0\nv 1 0 0\nv 0 1 0 \\\n\nvn 0 0 1\nf 1/1/1 -2//1 \\\n3\n".to_vec(),
        ),
    ];
    let folder = Folder::new();
    for (format, whole) in files {
        for at in 0..whole.len() {
            for value in [0, b'\n', b' ', b'\\', b'-', b'9', 0x7f, 0xff, whole[at] ^ 1] {
                let mut bytes = whole.clone();
                bytes[at] = value;
                let path = folder.write("tile", &bytes);
                if let Ok(tile) = read_tile(&path, format, &ReadOptions::default()) {
                    let count = tile.mesh.positions.len() as u32;
                    assert!(tile.mesh.triangles.iter().flatten().all(|&v| v < count), "byte {at} = {value}");
                }
            }
        }
    }
}

#[cfg(unix)]
#[test]
fn what_is_no_file_is_named() {
    let folder = Folder::new();
    let message = |name: &str, format| {
        let error = read_tile(&folder.path(name), format, &ReadOptions::default()).expect_err(name);
        (without_folder(&error.to_string(), &folder), error.errno())
    };
    for format in [TileFormat::Ply, TileFormat::Obj] {
        let (text, errno) = message("absent", format);
        assert!(text.starts_with("absent: cannot open: No such file"), "{text}");
        assert_eq!(errno, Some(2));
        std::fs::create_dir_all(folder.path("folder")).expect("folder");
        let (text, _) = message("folder", format);
        assert!(text.starts_with("folder: the file as a whole: not supported: this is a folder; "), "{text}");
    }
    std::os::unix::fs::symlink(folder.path("loop"), folder.path("loop")).expect("link");
    assert!(message("loop", TileFormat::Obj).1.is_some());
    let (text, _) = {
        let error =
            read_tile("/dev/zero".as_ref(), TileFormat::Obj, &ReadOptions::default()).expect_err("device");
        (error.to_string(), ())
    };
    assert!(text.contains("not a regular file"), "{text}");
}

#[test]
fn a_file_over_the_limit_is_not_read() {
    let folder = Folder::new();
    let path = folder.write("tile", vec![b'\n'; 1000]);
    for (limit, is_refused) in [(999, true), (1000, false)] {
        let options = ReadOptions { max_bytes: Some(limit), ..ReadOptions::default() };
        let got = read_tile(&path, TileFormat::Obj, &options);
        assert_eq!(matches!(got, Err(TileError::TooLarge { bytes: 1000, limit_bytes: 999, .. })), is_refused);
    }
}

#[test]
fn patches_that_do_not_fit_are_refused() {
    let folder = Folder::new();
    let obj = folder.write("in.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let ply_file = folder.write("in.ply", triangle(FACE, &row(&[0, 1, 2])));
    let bad = |vertices: &[[f64; 3]], triangle| patch("h\n1", vertices, &[triangle]);
    let cases: [(HolePatch, &str); 4] = [
        (bad(&[], [old(0), old(1), old(3)]), "triangle 0 has the corner Original(v3), but there are 3"),
        (bad(&[[0.; 3]], [old(0), old(1), new(1)]), "triangle 0 has the corner New(1), but there are 1"),
        (bad(&[[0.; 3]], [old(0), old(0), new(0)]), "triangle 0 names a corner twice"),
        (bad(&[[0., f64::NAN, 0.]], [old(0), old(1), new(0)]), "new vertex 0 is not finite"),
    ];
    for (wrong, want) in cases {
        for (input, format) in [(&obj, TileFormat::Obj), (&ply_file, TileFormat::Ply)] {
            let output = folder.path("out");
            let options = ReadOptions::default();
            let patches = [wrong.clone()];
            let request = AppendRequest {
                input,
                output: &output,
                format,
                options: &options,
                expected_hash: None,
                patches: &patches,
            };
            let error = append_patches(&request).expect_err(want);
            assert!(matches!(error, TileError::BadPatch { .. }));
            assert!(error.to_string().contains(&format!("patch of hole h\\n1: {want}; ")), "{error}");
            assert!(!output.exists());
        }
    }
}
