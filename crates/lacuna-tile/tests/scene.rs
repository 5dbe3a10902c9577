//! Scenes: what counts as a tile, what belongs together, what is refused.

#![allow(clippy::print_stderr, reason = "a test that skips says so")]

use lacuna_tile::{SceneOptions, TileName, format_like, hollow_tile_path, open_scene, output_path};
use proptest::prelude::*;
use std::fs;
use std::path::{Path, PathBuf};

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

/// A temporary folder with the given files in it; OBJ files hold one triangle.
fn scene_of(files: &[&str]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("temporary folder");
    for file in files {
        let path = folder.path().join(file);
        fs::create_dir_all(path.parent().expect("parent")).expect("folder");
        fs::write(path, TRIANGLE).expect("write");
    }
    folder
}

/// Groups as `name@index[parts]`, or the refusal without the folder's own path.
fn summary(root: &Path) -> String {
    match open_scene(root, &SceneOptions::default()) {
        Ok(scene) => {
            let groups: Vec<String> = scene
                .groups
                .iter()
                .map(|g| {
                    let index = g.index.map_or("?".into(), |(x, y)| format!("{x},{y}"));
                    let sure = if g.index_is_signed { "" } else { "~" };
                    format!("{}@{sure}{index}[{}]", g.name, g.parts.len())
                })
                .collect();
            groups.join(" ")
        }
        Err(error) => format!("{error}").replace(&root.display().to_string(), "."),
    }
}

#[test]
fn files_group_as_listed() {
    let cases: [(&[&str], &str); 11] = [
        (&["Data/Tile_+000_+001/Tile_+000_+001.obj"], "Tile_+000_+001@0,1[1]"),
        (
            &["Tile_+000_+001_L17.obj", "Block_+001_+001_L17.obj"],
            "Block_+001_+001@1,1[1] Tile_+000_+001@0,1[1]",
        ),
        (
            &[
                "T/Tile_+000_+013_L19_0uuuu0.obj",
                "T/Tile_+000_+013_L19_0uuuu7.obj",
                "T/Tile_+000_+013_L19_0uuuu3.obj",
            ],
            "Tile_+000_+013@0,13[3]",
        ),
        (&["cell_00_00.obj", "cell_00_01.obj"], "cell_00_00@~0,0[1] cell_00_01@~0,1[1]"),
        (&["cell_0_0_L5_0.obj", "cell_0_0_L5_1.obj"], "cell_0_0@~0,0[2]"),
        (&["day_2024_05.obj", "night_2024_05.obj"], "day_2024_05@~?[1] night_2024_05@~?[1]"),
        (&["BlockA/Block.obj", "BlockR/Block.obj"], "BlockA/Block@~?[1] BlockR/Block@~?[1]"),
        (&["quay.OBJ", ".hidden.obj"], "quay@~?[1]"),
        (
            &["a/Tile_+000_+001_L17.obj", "a/Tile_+001_+001_L18.obj"],
            "Tile_+000_+001@0,1[1] Tile_+001_+001@1,1[1]",
        ),
        (&["x.obj", "y.ply"], "x@~?[1] y@~?[1]"),
        (&["é/Tile_-001_-002.obj"], "Tile_-001_-002@-1,-2[1]"),
    ];
    for (files, expected) in cases {
        assert_eq!(summary(scene_of(files).path()), expected, "files {files:?}");
    }
}

#[test]
fn what_has_no_grid_or_two_tiles_is_refused_by_name() {
    let cases: [(&[&str], &[&str]); 12] = [
        (&["a.obj", "a.ply"], &["a.obj", "a.ply", "one format"]),
        (&["L17/Tile_+000_+001.obj", "L18/Tile_+000_+001.obj"], &["L17/", "L18/", "cell +0,+1"]),
        (&["Tile_+000_+001_L17.obj", "Tile_+000_+001_L18.obj"], &["_L17.obj", "_L18.obj", "one level"]),
        (&["Tile_+000_+001_L17_0.obj", "Tile_+000_+001_L18_1.obj"], &["_L17_0.obj", "_L18_1.obj"]),
        (&["Tile_+000_+001_L17_0.obj", "Tile_+000_+001_L17_1.ply"], &["_L17_0.obj", "_L17_1.ply"]),
        (&["Tile_+000_+001_L17_0.obj", "Tile_+00_+1_L17_0.obj"], &["are both the tile"]),
        (&["Tile_+000_+001_+002.obj"], &["Tile_+000_+001_+002.obj", "three indices"]),
        (&["Tile_+012.obj"], &["Tile_+012.obj", "one signed number"]),
        (&["readme.txt"], &["no tile found", ".ply, .obj and .glb"]),
        (
            &["Data/a.osgb", "Data/b.osgb"],
            &["2 .osgb", "osgconv in.osgb out.obj -O \"OutputTextureFiles precision=9\""],
        ),
        (&["tile.b3dm", "cloud.LAZ"], &["1 .b3dm", "b3dmToGlb", "1 .laz"]),
        (&[], &["no tile found"]),
    ];
    for (files, words) in cases {
        let message = summary(scene_of(files).path());
        for word in words {
            assert!(message.contains(word), "files {files:?}: {word:?} is missing in: {message}");
        }
    }
}

#[test]
fn paths_that_are_no_folder_are_named() {
    let folder = scene_of(&["a.obj"]);
    assert!(summary(&folder.path().join("a.obj")).contains("not a folder"));
    assert!(summary(&folder.path().join("absent")).contains("cannot open the scene"));
}

#[test]
fn everything_else_is_a_side_file() {
    let folder = scene_of(&["t/a.obj", "t/a.mtl", "t/a 1.jpg", "metadata.json", ".dot/x", "t/.a.obj"]);
    let scene = open_scene(folder.path(), &SceneOptions::default()).expect("scene");
    assert_eq!(scene.side_files, [".dot/x", "metadata.json", "t/.a.obj", "t/a 1.jpg", "t/a.mtl"]);
    assert_eq!(scene.tiles.len(), 1);
    assert!(scene.tiles[0].header.is_ok());
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
}

#[test]
fn a_bad_header_stays_with_its_tile() {
    let folder = scene_of(&["good.obj"]);
    fs::write(folder.path().join("bad.ply"), "not a ply").expect("write");
    fs::write(folder.path().join("worse.glb"), "not a glb").expect("write");
    let scene = open_scene(folder.path(), &SceneOptions::default()).expect("scene");
    let bad: Vec<&str> =
        scene.tiles.iter().filter(|t| t.header.is_err()).map(|t| t.relative.as_str()).collect();
    assert_eq!(bad, ["bad.ply", "worse.glb"]);
}

#[test]
fn records_of_an_earlier_run_are_left_out() {
    let folder =
        scene_of(&["a.obj", "lacuna/manifest.json", "lacuna/report.json", "deep/lacuna/manifest.json"]);
    let scene = open_scene(folder.path(), &SceneOptions::default()).expect("scene");
    assert_eq!(scene.side_files, ["deep/lacuna/manifest.json"]);
    assert_eq!(scene.warnings, ["lacuna: records of an earlier run: left out"]);
}

#[cfg(unix)]
#[test]
fn links_are_followed_inside_the_scene_only() {
    use std::os::unix::fs::symlink;
    let outside = scene_of(&["secret.obj"]);
    let folder = scene_of(&["a/in.obj", "textures/x.jpg"]);
    let root = folder.path();
    symlink(root.join("textures"), root.join("a/tex")).expect("link");
    symlink(outside.path().join("secret.obj"), root.join("out.obj")).expect("link");
    symlink(outside.path(), root.join("out_folder")).expect("link");
    symlink(root, root.join("a/loop")).expect("link");
    symlink("nowhere", root.join("dangling")).expect("link");
    let followed = open_scene(root, &SceneOptions::default()).expect("scene");
    assert_eq!(followed.side_files, ["a/tex/x.jpg", "textures/x.jpg"]);
    assert_eq!(followed.tiles.len(), 1);
    assert_eq!(
        followed.warnings,
        [
            "a/loop: a symbolic link to a folder above it: not followed",
            "dangling: a symbolic link to nothing: left out",
            "out.obj: a symbolic link that leaves the scene: not followed",
            "out_folder: a symbolic link that leaves the scene: not followed",
        ]
    );
    let strict = open_scene(root, &SceneOptions { follow_symlinks: false }).expect("scene");
    assert_eq!(strict.side_files, ["textures/x.jpg"]);
    assert_eq!(strict.warnings.len(), 5);
}

#[cfg(unix)]
#[test]
fn special_files_and_hostile_names_do_no_harm() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;
    let folder = scene_of(&["a.obj", "esc\u{1b}[31m\n<script>.jpg", "CON", "trailing.", "\u{202e}gpj.exe"]);
    let socket = folder.path().join("socket.obj");
    let _listener = std::os::unix::net::UnixListener::bind(&socket).expect("socket");
    let scene = open_scene(folder.path(), &SceneOptions::default()).expect("scene");
    assert_eq!((scene.tiles.len(), scene.side_files.len()), (1, 4));
    assert_eq!(scene.warnings, ["socket.obj: not a regular file: left out"]);

    let folder = scene_of(&["a\u{1b}[2J.obj", "a\u{1b}[2J.ply"]);
    assert!(!summary(folder.path()).contains('\u{1b}'), "escape codes do not reach messages");

    let folder = scene_of(&["a.obj"]);
    fs::write(folder.path().join(OsStr::from_bytes(b"x\xff.jpg")), "x").expect("write");
    assert!(summary(folder.path()).contains("not UTF-8"));
}

#[test]
fn metadata_is_found_beside_or_above() {
    let folder = scene_of(&["Data/Tile_+000_+000.obj"]);
    let xml = "<ModelMetadata version=\"1\"><SRS>EPSG:4549</SRS><SRSOrigin>1,2,3</SRSOrigin></ModelMetadata>";
    fs::write(folder.path().join("metadata.xml"), xml).expect("write");
    let scene = open_scene(&folder.path().join("Data"), &SceneOptions::default()).expect("scene");
    let metadata = scene.metadata.expect("metadata");
    assert_eq!((metadata.source.as_str(), metadata.srs_origin), ("../metadata.xml", [1.0, 2.0, 3.0]));
    fs::write(folder.path().join("metadata.xml"), b"\xff\xfe").expect("write");
    assert!(summary(folder.path()).contains("not UTF-8"));
}

#[test]
fn hollow_cells_are_named_like_their_neighbours() {
    let cases: [(&[&str], (i32, i32), &str); 8] = [
        (
            &["Data/Tile_+000_+012/Tile_+000_+012_L17.obj"],
            (-1, 13),
            "Data/Tile_-001_+013/Tile_-001_+013_L17.obj",
        ),
        (&["cell_00_01.ply"], (-1, 2), "cell_-01_02.ply"),
        (&["any/Tile_+0_+0.glb"], (12, -3), "any/Tile_+12_-3.glb"),
        (&["x_1_2/cell_00_01.obj"], (0, 5), "x_1_2/cell_00_05.obj"),
        (&["BlockA/Block.obj"], (3, -4), "BlockA/Block_hollow_x3_y-4.obj"),
        (&["Tile_+000_+000.obj", "Tile_+000_+001.jpg"], (0, 1), "Tile_+000_+001.obj"),
        (&["a.b/Tile_+000_+000.v2.obj"], (0, 1), "a.b/Tile_+000_+001.v2.obj"),
        (&["cell_0_0.obj", "CELL_0_1.OBJ"], (0, 1), "CELL_0_1_lacuna.OBJ"),
    ];
    for (files, index, expected) in cases {
        let folder = scene_of(files);
        let scene = open_scene(folder.path(), &SceneOptions::default()).expect("scene");
        assert_eq!(hollow_tile_path(&scene, index, &scene.groups[0]), expected, "files {files:?}");
    }
}

#[test]
fn the_order_of_creation_does_not_matter() {
    let mut files =
        ["b/Tile_+001_+000.obj", "a/Tile_+000_+000.obj", "c.txt", "a/x.jpg", "Tile_-001_+000.obj"];
    let listing = |files: &[&str]| {
        let folder = scene_of(files);
        let scene = open_scene(folder.path(), &SceneOptions::default()).expect("scene");
        let tiles: Vec<String> = scene.tiles.iter().map(|t| t.relative.clone()).collect();
        (tiles, scene.side_files, scene.groups)
    };
    let first = listing(&files);
    files.reverse();
    assert_eq!(listing(&files), first);
    files.swap(0, 3);
    assert_eq!(listing(&files), first);
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, rng_seed: proptest::test_runner::RngSeed::Fixed(11), ..ProptestConfig::default() })]

    #[test]
    fn names_made_like_others_read_back(x in any::<i32>(), y in any::<i32>(), signed in any::<bool>(), tail in "(_L[0-9]{1,2}(_[0-7u]{1,9})?)?") {
        let stem = if signed { format!("Some Tile_+007_-01{tail}") } else { format!("Some Tile_007_01{tail}") };
        let template = TileName::parse(&stem).expect("a name");
        let made = TileName::parse(&format_like(&template, (x, y))).expect("a name again");
        prop_assert_eq!(made.index, (x, y));
        prop_assert_eq!(&made.prefix, "Some Tile");
        prop_assert_eq!(made.tail.unwrap_or_default(), tail);
        prop_assert_eq!(made.signed, signed || (x < 0 && y < 0), "two minus signs look like a signed pair");
    }

    #[test]
    fn any_text_is_a_name_or_not(stem in "[_+0-9Lué-]{0,24}|.{0,24}") {
        if let Some(name) = TileName::parse(&stem).filter(|name| name.z.is_none()) {
            prop_assert_eq!(format_like(&name, name.index), stem);
        }
    }

    #[test]
    fn no_path_leaves_the_output(relative in "[./a\\\\:]{0,12}|.{0,12}") {
        if let Ok(path) = output_path(Path::new("/out"), &relative) {
            prop_assert!(path.starts_with("/out"));
            let inside = path.strip_prefix("/out").expect("inside");
            prop_assert!(inside.components().all(|c| matches!(c, std::path::Component::Normal(_))));
        }
    }
}

fn shared_data(path: &str) -> Option<PathBuf> {
    let found = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data").join(path);
    if !found.exists() {
        eprintln!("skipped: ../shared/data/{path} is absent");
        return None;
    }
    Some(found)
}

#[test]
fn real_scenes_open() {
    let Some(root) = shared_data("contextcapture-tiles/obj/L17") else { return };
    assert_eq!(
        summary(&root),
        "Tile_+000_+012@0,12[1] Tile_+000_+013@0,13[1] Tile_+000_+014@0,14[1] Tile_+000_+015@0,15[1]"
    );
    let scene = open_scene(&root, &SceneOptions::default()).expect("scene");
    let metadata = scene.metadata.expect("two folders up");
    assert_eq!(metadata.source, "../../metadata.xml");
    assert_eq!(metadata.srs_origin, [501_027.524, 2_488_718.808, 0.0]);
    assert!(metadata.srs.is_some_and(|srs| srs.starts_with("PROJCS[")));
    assert_eq!(scene.side_files.len(), 8);
}

#[test]
fn real_parts_are_one_tile() {
    let Some(root) = shared_data("contextcapture-tiles/obj/L19") else { return };
    let files = fs::read_dir(root.join("Tile_+000_+013")).expect("folder").flatten();
    let objs = files.filter(|f| f.path().extension().is_some_and(|e| e == "obj")).count();
    assert_eq!(summary(&root), format!("Tile_+000_+013@0,13[{objs}]"));
    assert!(objs > 1);
}

#[test]
fn real_levels_side_by_side_are_refused() {
    let Some(root) = shared_data("contextcapture-tiles/obj") else { return };
    let message = summary(&root);
    assert!(message.contains("L17") && message.contains("L18") && message.contains("one level"), "{message}");
}
