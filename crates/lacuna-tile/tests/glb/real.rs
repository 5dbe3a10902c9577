//! Files of real producers and of the Khronos validator.

use crate::support::*;
use glam::DVec3;
use lacuna_tile::{ReadOptions, TileError, TileFormat, read_header, read_tile};
use std::fs;
use std::path::{Path, PathBuf};

fn shared_data(path: &str) -> Option<PathBuf> {
    let found = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data").join(path);
    if !found.exists() {
        eprintln!("skipped: ../shared/data/{path} is absent");
        return None;
    }
    Some(found)
}

/// The GLB inside a b3dm file: its header names the sizes of the tables before it.
fn glb_of_b3dm(file: &[u8]) -> Vec<u8> {
    let number = |at: usize| u32::from_le_bytes(file[at..at + 4].try_into().expect("four bytes")) as usize;
    let start = 28 + number(12) + number(16) + number(20) + number(24);
    file[start..].to_vec()
}

#[test]
fn real_tiles_read_or_are_refused_by_name() {
    let Some(folder) = shared_data("loadersgl-tiles") else { return };
    let cases = [
        ("frankfurt_474_5548_lv5_osgb3.b3dm", Err("Draco (KHR_draco_mesh_compression)")),
        ("helsinki_points_meshopt_0.glb", Err("meshopt (EXT_meshopt_compression)")),
        ("realitycapture_trianglestrip_lod1_0.b3dm", Ok(10_338)),
        ("vricon_muscatatuck_0_0_0.glb", Ok(91)),
        ("ferry_0000000.glb", Ok(36_334)),
    ];
    for (name, expected) in cases {
        let mut file = fs::read(folder.join(name)).expect("read");
        if name.ends_with(".b3dm") {
            file = glb_of_b3dm(&file);
        }
        match (read_bytes(&file), expected) {
            (Ok(tile), Ok(vertices)) => {
                assert_eq!(tile.mesh.positions.len(), vertices, "{name}");
                assert!(tile.mesh.triangles.len() > 50, "{name}");
                check_append(name, &file);
            }
            (Err(error), Err(word)) => assert!(error.to_string().contains(word), "{name}: {error}"),
            (result, _) => panic!("{name}: {:?}", result.map(|tile| tile.mesh.positions.len())),
        }
    }
}

#[test]
fn real_strips_become_a_closed_surface_that_looks_outwards() {
    let Some(folder) = shared_data("loadersgl-tiles") else { return };
    let file = fs::read(folder.join("realitycapture_trianglestrip_lod1_0.b3dm")).expect("read");
    let tile = read_bytes(&glb_of_b3dm(&file)).expect("read");
    let (mut area, mut total, mut volume) = (DVec3::ZERO, 0.0, 0.0);
    for t in 0..tile.mesh.triangles.len() {
        let [a, b, c] = tile.mesh.corners(t);
        let normal = (b - a).cross(c - a) / 2.0;
        area += normal;
        total += normal.length();
        volume += a.dot(normal) / 3.0;
    }
    // A strip whose winding did not alternate would leave half of its area uncancelled.
    assert!(area.length() < 1e-5 * total, "area vectors cancel: {area} of {total} m2");
    assert!(volume > 0.0, "outwards: {volume} m3");
}

/// Every GLB below a folder, sorted.
fn glb_files(folder: &Path, found: &mut Vec<PathBuf>) {
    let mut entries: Vec<PathBuf> =
        fs::read_dir(folder).expect("folder").flatten().map(|e| e.path()).collect();
    entries.sort();
    for path in entries {
        if path.is_dir() {
            glb_files(&path, found);
        } else if path.extension().is_some_and(|e| e == "glb") {
            found.push(path);
        }
    }
}

#[test]
fn validator_files_read_or_are_refused() {
    let Some(folder) = shared_data("gltf-validator-files") else { return };
    let mut files = Vec::new();
    glb_files(&folder, &mut files);
    assert!(files.len() >= 37, "{} GLB files", files.len());
    for path in &files {
        let whole = read_tile(path, TileFormat::Glb, &ReadOptions::default());
        if let Err(error) = &whole {
            assert!(!error.to_string().is_empty());
            assert!(matches!(error, TileError::Malformed { .. } | TileError::Unsupported { .. }), "{error}");
        }
        let _ = read_header(path, TileFormat::Glb);
    }
}

#[test]
fn validator_documents_read_or_are_refused() {
    let Some(folder) = shared_data("gltf-validator-files") else { return };
    let mut waiting = vec![folder];
    let mut count = 0;
    while let Some(folder) = waiting.pop() {
        for path in fs::read_dir(folder).expect("folder").flatten().map(|entry| entry.path()) {
            if path.is_dir() {
                waiting.push(path);
            } else if path.extension().is_some_and(|e| e == "gltf") {
                let text = fs::read(&path).expect("read");
                let mut file = b"glTF\x02\0\0\0\0\0\0\0".to_vec();
                push_chunk(&mut file, b"JSON", &text, b' ');
                set_length(&mut file);
                let case = Case::new(&file);
                if let Ok(tile) = case.read() {
                    let _ = case.append(&[free_patch(vec![DVec3::ZERO, DVec3::X, DVec3::Y])]);
                    assert!(
                        tile.mesh
                            .triangles
                            .iter()
                            .flatten()
                            .all(|&v| (v as usize) < tile.mesh.positions.len())
                    );
                }
                count += 1;
            }
        }
    }
    assert!(count > 200, "{count} documents");
}
