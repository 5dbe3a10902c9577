//! OBJ: dialects in, patches appended, compared with an independent reader.

mod common;

use common::{Folder, files_below, new, old, patch, shared_data};
use glam::DVec3;
use lacuna_tile::{
    AppendRequest, HolePatch, NewTileRequest, ReadOptions, ReadTile, TileError, TileFormat, UpAxis, Written,
    append_patches, new_tile, read_header, read_tile,
};
use proptest::prelude::*;
use std::fs;
use std::path::Path;

fn read(path: &Path) -> Result<ReadTile, TileError> {
    read_tile(path, TileFormat::Obj, &ReadOptions::default())
}

fn append(input: &Path, output: &Path, patches: &[HolePatch]) -> Result<Written, TileError> {
    let options = ReadOptions::default();
    append_patches(&AppendRequest {
        input,
        output,
        format: TileFormat::Obj,
        options: &options,
        expected_hash: None,
        patches,
    })
}

const NONE: &[&str] = &[];

/// name, text, positions, triangles, warnings
type Case = (&'static str, &'static str, &'static [[f64; 3]], &'static [[u32; 3]], &'static [&'static str]);

const UNIT: &[[f64; 3]] = &[[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]];
const QUAD: &[[f64; 3]] = &[[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]];
const ARROW: &[[f64; 3]] = &[[0., 0., 0.], [2., 2., 0.], [0., 1., 0.], [-2., 2., 0.]];

const CASES: &[Case] = &[
    ("plain", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", UNIT, &[[0, 1, 2]], NONE),
    ("a/b", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1 3/1\n", UNIT, &[[0, 1, 2]], NONE),
    ("a//c", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//1\n", UNIT, &[[0, 1, 2]], NONE),
    ("a/b/c", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\nf 1/1/1 2/1/1 3/1/1\n", UNIT, &[[0, 1, 2]], NONE),
    ("a/b/ (osgconv)", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1/ 2/1/ 3/1/ \n", UNIT, &[[0, 1, 2]], NONE),
    (
        "relative indices, where they stand",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 5 5 5\nf -4/-1 -2 -1\n",
        &[[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [5., 5., 5.]],
        &[[0, 1, 2], [0, 2, 3]],
        NONE,
    ),
    ("convex quad", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n", QUAD, &[[0, 1, 2], [0, 2, 3]], NONE),
    (
        "concave quad, wrong diagonal first",
        "v 0 0 0\nv 2 2 0\nv 0 1 0\nv -2 2 0\nf 2 3 4 1\n",
        ARROW,
        &[[0, 1, 2], [2, 3, 0]],
        NONE,
    ),
    ("faces before vertices", "f 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\n", UNIT, &[[0, 1, 2]], NONE),
    (
        "polygon before vertices",
        "f 2 3 4 1\nf 1 2 3\nv 0 0 0\nv 2 2 0\nv 0 1 0\nv -2 2 0\n",
        ARROW,
        &[[0, 1, 2], [2, 3, 0], [0, 1, 2]],
        NONE,
    ),
    ("weights", "v 0 0 0 1\nv 1 0 0 0.5\nv 0 1 0 2\nf 1 2 3\n", UNIT, &[[0, 1, 2]], NONE),
    ("CRLF", "v 0 0 0\r\nv 1 0 0\r\nv 0 1 0\r\nf 1 2 3\r\n", UNIT, &[[0, 1, 2]], NONE),
    ("CRLF without an end", "v 0 0 0\r\nv 1 0 0\r\nv 0 1 0\r\nf 1 2 3", UNIT, &[[0, 1, 2]], NONE),
    (
        "tabs, runs of blanks, indents",
        "  v\t0   0\t0  \n\tv 1 0 0\n v 0\t1 0\n\n  f  1\t2   3  ",
        UNIT,
        &[[0, 1, 2]],
        NONE,
    ),
    ("continuations", "v 0 0 \\\n0\nv 1 \\\r\n0 0\nv 0 1 0\nf 1\\\n 2 \\\n\\\n3\n", UNIT, &[[0, 1, 2]], NONE),
    ("continuation at the end", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\\", UNIT, &[[0, 1, 2]], NONE),
    (
        "a continued name does not become a vertex",
        "v 0 0 0\ng a \\\nv 9 9 9\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
        UNIT,
        &[[0, 1, 2]],
        NONE,
    ),
    (
        "a comment's backslash is text",
        "v 0 0 0\n# C:\\tiles\\\nv 1 0 0\nv 0 1 0 # \\\nf 1 2 3\n",
        UNIT,
        &[[0, 1, 2]],
        NONE,
    ),
    ("comment tails", "v 0 0 0#x\nv 1 0 0 # 7 7 7\nv 0 1 0\nf 1 2 3 # 1\n", UNIT, &[[0, 1, 2]], NONE),
    ("a mark of UTF-8", "\u{feff}v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", UNIT, &[[0, 1, 2]], NONE),
    (
        "all other statements",
        "mtllib a.mtl\no x\nv 0 0 0\nusemtl a b\nvp 1 2\nv 1 0 0\nv 0 1 0\ns off\np 1\nl 1 2\ncurv 0 1 1 2\nf 1 2 3\n",
        UNIT,
        &[[0, 1, 2]],
        NONE,
    ),
    (
        "numbers",
        "v +1 -2. .5\nv 1e2 2.e1 3.5E-1\nv +1e+2 -0 00012\n",
        &[[1., -2., 0.5], [100., 20., 0.35], [100., 0., 12.]],
        &[],
        NONE,
    ),
    (
        "numbers with an odd end",
        "v 1 2 3.1+e2\n",
        &[[1., 2., 3.1]],
        &[],
        &["1 numbers with an unreadable end; what stands before it counts"],
    ),
    (
        "short faces",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2\nf\nf 1 2 3\n",
        UNIT,
        &[[0, 1, 2]],
        &["2 faces with fewer than three corners passed over"],
    ),
    ("nothing", "", &[], &[], NONE),
    ("comments alone", "# nothing\n", &[], &[], NONE),
];

#[test]
fn dialects() {
    let folder = Folder::new();
    for (name, text, positions, triangles, warnings) in CASES {
        let path = folder.write("tile.obj", text);
        let tile = read(&path).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!(
            tile.mesh.positions,
            positions.iter().map(|&p| DVec3::from(p)).collect::<Vec<_>>(),
            "{name}"
        );
        assert_eq!(tile.mesh.triangles, *triangles, "{name}");
        assert_eq!(tile.warnings, *warnings, "{name}");
        assert_eq!(tile.hash, *blake3::hash(text.as_bytes()).as_bytes(), "{name}");
        assert!(!tile.has_colour, "{name}");
    }
}

#[test]
fn a_long_line_and_a_large_polygon() {
    let folder = Folder::new();
    let mut text = format!("# {}\n", "x".repeat(3_000_000));
    let n = 20_000;
    for k in 0..n {
        let angle = f64::from(k) * std::f64::consts::TAU / f64::from(n);
        let radius = if k % 2 == 0 { 10.0 } else { 9.0 };
        text += &format!("v {} {} 0\n", radius * angle.cos(), radius * angle.sin());
    }
    text.push('f');
    (1..=n).for_each(|k| text += &format!(" {k}"));
    let tile = read(&folder.write("tile.obj", text)).expect("tile");
    assert_eq!(tile.mesh.triangles.len(), n as usize - 2);
}

#[test]
fn non_finite_vertices_stay_and_their_triangles_go() {
    let folder = Folder::new();
    let path = folder.write(
        "tile.obj",
        "v 0 0 0\nv nan 0 0\nv 1 0 0\nv 0 inf 1e999\nv 0 1 0\nf 1 2 3\nf 1 3 5\nf 3 4 5 1\n",
    );
    let tile = read(&path).expect("tile");
    assert_eq!(tile.mesh.positions.len(), 5);
    assert!(tile.mesh.positions[1].x.is_nan() && tile.mesh.positions[3].z.is_infinite());
    let touched = tile.mesh.triangles.iter().flatten().any(|&v| v == 1 || v == 3);
    assert!(tile.mesh.triangles.contains(&[0, 2, 4]) && !touched);
    assert_eq!(tile.warnings.len(), 1);
    assert!(tile.warnings[0].starts_with("2 vertices are not finite; "), "{:?}", tile.warnings);
}

#[test]
fn library_names_are_the_rest_of_the_line() {
    let folder = Folder::new();
    let text =
        "mtllib ./a b.mtl\nmtllib\tc.mtl  \r\nmtllibrary no\nmtllib ../../etc/passwd\nusemtl x\nv 0 0 0";
    let tile = read(&folder.write("tile.obj", text)).expect("tile");
    assert_eq!(tile.textures, ["./a b.mtl", "c.mtl", "../../etc/passwd"]);
}

/// The closed square with one new vertex in its middle, over the first two corners.
fn small_patch() -> HolePatch {
    patch("84512_447233.h1", &[[0.5, 0.1, 0.25]], &[[old(0), old(1), new(0)]])
}

const HEAD: &str = "# lacuna patch\nmtllib out_lacuna.mtl\ng lacuna_patch\nusemtl lacuna_patch\ns off\n";

#[test]
fn patches_are_statements_behind_the_original() {
    let (folder, target) = (Folder::new(), Folder::new());
    let unit = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    let plain = format!("{HEAD}v 0.5 0.1 0.25\n# hole 84512_447233.h1\nf 1 2 4\n");
    let cases = [
        ("plain", format!("{unit}f 1 2 3\n"), "", plain.clone()),
        ("no last line end", format!("{unit}f -1 -2 -3"), "\n", plain.clone()),
        ("open continuation", format!("{unit}f 1 2 3 \\"), "\n\n", plain.clone()),
        ("open continuation and line end", format!("{unit}f 1 2 3 \\\n"), "\n", plain.clone()),
        ("CRLF", format!("{unit}f 1 2 3\n").replace('\n', "\r\n"), "", plain.replace('\n', "\r\n")),
        (
            "colours",
            "v 0 0 0 0.1 0.2 0.3\nv 1 0 0 0.2 0.3 0.4\nv 0 1 0 1 1 1\nf 1 2 3\n".to_owned(),
            "",
            format!("{HEAD}v 0.5 0.1 0.25 0.15 0.25 0.35\n# hole 84512_447233.h1\nf 1 2 4\n"),
        ),
        (
            "colours of four numbers",
            "v 0 0 0 0.1 0.2 0.3 1\nv 1 0 0 0.2 0.3 0.4 1\nv 0 1 0 1 1 1 1\nf 1 2 3\n".to_owned(),
            "",
            format!("{HEAD}v 0.5 0.1 0.25 0.15 0.25 0.35 1\n# hole 84512_447233.h1\nf 1 2 4\n"),
        ),
    ];
    for (name, original, closing, statements) in cases {
        let (input, output) = (folder.write("in.obj", &original), target.path("out.obj"));
        let before = read(&input).expect(name);
        let written = append(&input, &output, &[small_patch()]).expect(name);
        let bytes = fs::read(&output).expect(name);
        assert_eq!(String::from_utf8_lossy(&bytes), format!("{original}{closing}{statements}"), "{name}");
        assert_eq!(written.hash, *blake3::hash(&bytes).as_bytes(), "{name}");
        assert_eq!(written.side_files, ["out_lacuna.mtl"], "{name}");
        let after = read(&output).expect(name);
        assert_eq!(after.mesh.positions[..3], before.mesh.positions, "{name}");
        assert_eq!(after.mesh.positions[3..], [DVec3::new(0.5, 0.1, 0.25)], "{name}");
        assert_eq!(after.mesh.triangles[..1], before.mesh.triangles, "{name}");
        assert_eq!(after.mesh.triangles[1..], [[0, 1, 3]], "{name}");
        assert_eq!(after.has_colour, before.has_colour, "{name}");
    }
}

#[test]
fn normals_are_written_where_the_file_has_them() {
    let folder = Folder::new();
    let original = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//1\n";
    let input = folder.write("in.obj", original);
    let flat = patch("a", &[[1., 1., 0.]], &[[old(2), old(1), new(0)]]);
    let standing = patch("b", &[[0., 0., 1.]], &[[old(0), old(1), new(0)]]);
    append(&input, &folder.path("out.obj"), &[flat, standing]).expect("append");
    let text = fs::read_to_string(folder.path("out.obj")).expect("text");
    let want = "v 1 1 0\nv 0 0 1\nvn 0 0 1\nvn 0 0 1\nvn 0 0 1\nvn 0 -1 0\nvn 0 -1 0\nvn 0 -1 0\n\
        # hole a\nf 3//3 2//2 4//4\n# hole b\nf 1//5 2//6 5//7\n";
    assert!(text.ends_with(want), "{text}");
}

#[test]
fn the_material_is_grey_or_the_patches_mean() {
    let (folder, target) = (Folder::new(), Folder::new());
    for (colour, want) in
        [("", "Kd 0.5 0.5 0.5"), (" 0.1 0.2 0.3", "Kd 0.1 0.2 0.3"), (" 51 102 255", "Kd 0.2 0.4 1")]
    {
        let original = format!("v 0 0 0{colour}\nv 1 0 0{colour}\nv 0 1 0{colour}\nf 1 2 3\n");
        let input = folder.write("in.obj", original);
        append(&input, &target.path("out.obj"), &[small_patch()]).expect("append");
        let material = fs::read_to_string(target.path("out_lacuna.mtl")).expect("material");
        assert!(
            material.contains("newmtl lacuna_patch\n") && material.contains(&format!("{want}\n")),
            "{material}"
        );
    }
}

#[test]
fn a_tile_repaired_before_keeps_its_material() {
    let folder = Folder::new();
    let input = folder.write("out.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    folder.write("out_lacuna.mtl", "newmtl lacuna_patch\n");
    let target = Folder::new();
    let written = append(&input, &target.path("out.obj"), &[small_patch()]).expect("append");
    assert_eq!(written.side_files, ["out_lacuna2.mtl"]);
    let tile = read(&target.path("out.obj")).expect("tile");
    assert_eq!(tile.textures, ["out_lacuna2.mtl"]);
    assert_eq!(target.names(), ["out.obj", "out_lacuna2.mtl"]);
}

#[test]
fn no_patches_are_the_same_bytes_and_no_side_file() {
    let folder = Folder::new();
    let input = folder.write("in.obj", "v 0 0 0\\");
    let written = append(&input, &folder.path("out.obj"), &[]).expect("append");
    assert_eq!(fs::read(folder.path("out.obj")).expect("out"), b"v 0 0 0\\");
    assert_eq!(written.side_files, NONE);
    assert_eq!(folder.names(), ["in.obj", "out.obj"]);
}

#[test]
fn new_tiles_are_coloured_and_shaded_as_the_template() {
    let folder = Folder::new();
    let corners = [[0., 0., 1.], [1., 0., 1.], [0., 1., 1.]];
    let patches = [patch("h", &corners, &[[new(0), new(1), new(2)]])];
    let options = ReadOptions::default();
    let cases = [
        ("v 9 9 9\n", "v 0 0 1\nv 1 0 1\nv 0 1 1\n# hole h\nf 1 2 3\n"),
        (
            "v 9 9 9 1 0 0\nv 9 9 9 0 0 1\nvn 1 0 0\n",
            "v 0 0 1 0.5 0 0.5\nv 1 0 1 0.5 0 0.5\nv 0 1 1 0.5 0 0.5\nvn 0 0 1\nvn 0 0 1\nvn 0 0 1\n# hole h\nf 1//1 2//2 3//3\n",
        ),
    ];
    for (template, want) in cases {
        let template = folder.write("in.obj", template);
        let output = folder.path("out.obj");
        let request = NewTileRequest {
            template: &template,
            output: &output,
            format: TileFormat::Obj,
            options: &options,
            patches: &patches,
        };
        let written = new_tile(&request).expect("new tile");
        assert_eq!(fs::read_to_string(&output).expect("text"), format!("{HEAD}{want}"));
        assert_eq!(written.side_files, ["out_lacuna.mtl"]);
        let wrong = [patch("h", &corners, &[[old(0), new(1), new(2)]])];
        assert!(matches!(
            new_tile(&NewTileRequest { patches: &wrong, ..request }),
            Err(TileError::BadPatch { .. })
        ));
    }
}

#[test]
fn the_up_axis_turns_both_ways() {
    let folder = Folder::new();
    let input = folder.write("in.obj", "v 1 2 3\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let options = ReadOptions { up_axis: Some(UpAxis::Y), ..ReadOptions::default() };
    let before = read_tile(&input, TileFormat::Obj, &options).expect("tile");
    assert_eq!(before.mesh.positions[0], DVec3::new(1., -3., 2.));
    let output = folder.path("out.obj");
    let point = DVec3::new(0.1, -0.7, 500_000.3);
    assert_eq!(before.frame.round(point), point, "decimals keep every bit");
    let patches = [patch("h", &[point.to_array()], &[[old(0), old(1), new(0)]])];
    let request = AppendRequest {
        input: &input,
        output: &output,
        format: TileFormat::Obj,
        options: &options,
        expected_hash: Some(before.hash),
        patches: &patches,
    };
    append_patches(&request).expect("append");
    assert!(fs::read_to_string(&output).expect("text").contains("\nv 0.1 500000.3 0.7\n"));
    assert_eq!(read_tile(&output, TileFormat::Obj, &options).expect("tile").mesh.positions[3], point);
    fs::write(&input, "v 1 2 3\n").expect("write");
    assert!(matches!(append_patches(&request), Err(TileError::InputChanged { .. })));
}

/// Compares our reading with tobj's (its `map_Kd` and material files are not looked at).
fn agrees_with_tobj(path: &Path) -> bool {
    let mut text = std::io::BufReader::new(fs::File::open(path).expect("open"));
    let options = tobj::LoadOptions { triangulate: false, single_index: false, ..Default::default() };
    let Ok((models, _)) = tobj::load_obj_buf(&mut text, &options, |_| Ok(Default::default())) else {
        return false;
    };
    let tile = read(path).unwrap_or_else(|e| panic!("the oracle reads what we do not: {e}"));
    let mut triangles = tile.mesh.triangles.iter();
    for model in &models {
        let mut start = 0;
        let arities = if model.mesh.face_arities.is_empty() {
            vec![3; model.mesh.indices.len() / 3]
        } else {
            model.mesh.face_arities.clone()
        };
        for arity in arities {
            let face = &model.mesh.indices[start..start + arity as usize];
            start += arity as usize;
            let corner = |v: &u32| {
                DVec3::from_slice(&model.mesh.positions[3 * *v as usize..]).to_array().map(f64::to_bits)
            };
            let mut want: Vec<_> = face.iter().map(corner).collect();
            let mine = triangles.by_ref().take(face.len().saturating_sub(2)).flatten();
            let mut mine: Vec<_> =
                mine.map(|&v| tile.mesh.positions[v as usize].to_array().map(f64::to_bits)).collect();
            if face.len() == 3 {
                assert_eq!(mine, want, "{}", path.display());
            } else if face.len() > 3 {
                [&mut mine, &mut want].into_iter().for_each(|list| {
                    list.sort_unstable();
                    list.dedup();
                });
                assert_eq!(mine, want, "{}", path.display());
            }
        }
    }
    assert_eq!(triangles.next(), None, "{}: more triangles than the oracle has", path.display());
    true
}

#[test]
fn real_files_agree_with_tobj() {
    for (folder, least) in
        [("contextcapture-tiles/obj", 14), ("assimp-testmodels/OBJ", 8), ("pymeshlab-samples", 1)]
    {
        let Some(root) = shared_data(folder) else { continue };
        let compared = files_below(&root, "obj").iter().filter(|path| agrees_with_tobj(path)).count();
        assert!(compared >= least, "{folder}: {compared} files compared");
    }
}

#[test]
fn repaired_real_tiles_keep_every_byte_and_agree_with_tobj() {
    let Some(root) = shared_data("contextcapture-tiles/obj/L17") else { return };
    let folder = Folder::new();
    for path in files_below(&root, "obj") {
        let before = read(&path).expect("tile");
        let n = before.mesh.positions.len() as u32;
        let point = before.mesh.positions[7] + DVec3::splat(0.1);
        let patches =
            [patch("h", &[point.to_array()], &[[old(7), old(n - 1), new(0)], [old(3), new(0), old(2)]])];
        append(&path, &folder.path("out.obj"), &patches).expect("append");
        let (original, repaired) =
            (fs::read(&path).expect("in"), fs::read(folder.path("out.obj")).expect("out"));
        assert!(repaired.starts_with(&original));
        assert!(agrees_with_tobj(&folder.path("out.obj")));
        let after = read(&folder.path("out.obj")).expect("tile");
        assert_eq!(after.mesh.positions[..n as usize], before.mesh.positions);
        assert_eq!(after.mesh.positions[n as usize..], [point]);
        assert_eq!(after.mesh.triangles[before.mesh.triangles.len()..], [[7, n - 1, n], [3, n, 2]]);
    }
}

#[test]
fn sizes_are_estimated_within_a_tenth() {
    let Some(root) = shared_data("contextcapture-tiles/obj") else { return };
    for path in files_below(&root, "obj") {
        let header = read_header(&path, TileFormat::Obj).expect("header");
        let tile = read(&path).expect("tile");
        assert_eq!(header.bytes, tile.bytes);
        for (estimate, real) in
            [(header.vertices, tile.mesh.positions.len()), (header.triangles, tile.mesh.triangles.len())]
        {
            let ratio = estimate as f64 / real as f64;
            assert!((0.9..1.1).contains(&ratio), "{}: {estimate} of {real}", path.display());
        }
    }
}

#[test]
fn small_files_are_counted_exactly() {
    let folder = Folder::new();
    for text in [
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 1 2 3 4\n",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 1 2 3 4",
    ] {
        let header = read_header(&folder.write("tile.obj", text), TileFormat::Obj).expect("header");
        assert_eq!((header.vertices, header.triangles, header.bytes), (4, 3, text.len() as u64));
    }
}

/// Seconds that this thread has run on a processor.
fn processor_seconds() -> f64 {
    let text = fs::read_to_string("/proc/thread-self/schedstat").expect("Linux");
    text.split(' ').next().and_then(|n| n.parse::<f64>().ok()).expect("nanoseconds") / 1e9
}

/// Run by hand: `cargo test --release -p lacuna-tile --test obj -- --ignored --nocapture`.
#[test]
#[ignore = "a measurement; needs a quiet machine and a release build"]
fn reading_is_three_times_as_fast_as_tobj() {
    let folder = Folder::new();
    let side = 700;
    let mut text = String::new();
    for k in 0..side * side {
        let (x, y) = (f64::from(k % side) * 0.5137, f64::from(k / side) * 0.4931);
        text += &format!("v {:.6} {:.6} {:.6}\n", x, y + 1200.0, (x * 0.1).sin() * 7.0 + y * 0.01);
    }
    for k in (0..side * (side - 1)).filter(|k| k % side + 1 < side) {
        let (a, b, c, d) = (k + 1, k + 2, k + side + 1, k + side + 2);
        text += &format!("f {a} {b} {d}\nf {a} {d} {c}\n");
    }
    let path = folder.write("tile.obj", &text);
    let fastest = |run: &dyn Fn() -> usize| {
        let once = |_| {
            let start = processor_seconds();
            assert!(run() > 900_000);
            processor_seconds() - start
        };
        (0..5).map(once).fold(f64::INFINITY, f64::min)
    };
    let options = ReadOptions { skip_hash: true, ..ReadOptions::default() };
    let ours = fastest(&|| read_tile(&path, TileFormat::Obj, &options).expect("tile").mesh.triangles.len());
    let hashed = fastest(&|| read(&path).expect("tile").mesh.triangles.len());
    let theirs = fastest(&|| {
        let options = tobj::LoadOptions { triangulate: true, single_index: false, ..Default::default() };
        let mut file = std::io::BufReader::new(fs::File::open(&path).expect("open"));
        let models = tobj::load_obj_buf(&mut file, &options, |_| Ok(Default::default())).expect("tobj").0;
        models.iter().map(|m| m.mesh.indices.len() / 3).sum()
    });
    let megabytes = text.len() as f64 / 1e6;
    let line = format!("{megabytes:.0} MB: {ours:.3} s, with hash {hashed:.3} s, tobj {theirs:.3} s");
    assert!(theirs >= 3.0 * ours, "{line}");
    std::io::Write::write_all(&mut std::io::stdout(), format!("{line}\n").as_bytes()).expect("print");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn every_bit_of_a_decimal_comes_back(
        points in prop::collection::vec(prop::array::uniform3(any::<f64>().prop_filter("finite", |x| x.is_finite())), 3..30),
        added in prop::collection::vec(prop::array::uniform3(any::<f64>().prop_filter("finite", |x| x.is_finite())), 1..10),
    ) {
        let folder = Folder::new();
        let text: String = points.iter().map(|p| format!("v {:e} {} {:?}\n", p[0], p[1], p[2])).collect();
        let input = folder.write("in.obj", format!("{text}f 1 2 3"));
        append(&input, &folder.path("out.obj"), &[patch("h", &added, &[[old(0), old(1), new(0)]])]).expect("append");
        let after = read(&folder.path("out.obj")).expect("tile");
        let bits = |p: &DVec3| p.to_array().map(f64::to_bits);
        let want: Vec<_> = points.iter().chain(&added).map(|p| p.map(f64::to_bits)).collect();
        prop_assert_eq!(after.mesh.positions.iter().map(bits).collect::<Vec<_>>(), want);
        prop_assert_eq!(after.mesh.triangles, vec![[0, 1, 2], [0, 1, points.len() as u32]]);
    }
}
