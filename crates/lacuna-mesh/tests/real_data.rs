//! Boundaries of real meshes against counting edge by edge; skipped where the shared data are absent.
#![allow(clippy::print_stderr)] // says what was skipped

mod common;

use common::{boundary_net, brute_net, canonical, renumbered, shuffled_triangles};
use lacuna_mesh::{TriMesh, boundary, components, loops};
use std::path::{Path, PathBuf};

/// The files with this ending under a folder of the shared data, sorted.
fn files(folder: &str, ending: &str) -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data").join(folder);
    let mut folders = vec![root];
    let mut found = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
            let path = entry.path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == ending) {
                found.push(path);
            }
        }
    }
    found.sort();
    if found.is_empty() {
        eprintln!("skipped: no .{ending} files in ../shared/data/{folder}");
    }
    found
}

/// A plain reader of what these files hold, polygons as fans.
fn read(path: &Path) -> TriMesh {
    let text = String::from_utf8_lossy(&std::fs::read(path).expect("readable")).into_owned();
    let mut mesh = TriMesh::default();
    let is_off = path.extension().is_some_and(|e| e == "off");
    let mut lines = text.lines().map(|l| l.split('#').next().unwrap_or("").trim()).filter(|l| !l.is_empty());
    let mut left = 0usize;
    if is_off {
        let counts = lines.by_ref().find(|l| l.starts_with(|c: char| c.is_ascii_digit())).expect("counts");
        left = counts.split_whitespace().next().and_then(|n| n.parse().ok()).expect("vertex count");
    }
    for line in lines {
        let words: Vec<&str> = line.split_whitespace().collect();
        let (is_vertex, numbers) = match words[0] {
            "v" => (true, &words[1..]),
            "f" => (false, &words[1..]),
            _ if is_off && left > 0 => (true, &words[..]),
            _ if is_off => (false, &words[1..]),
            _ => continue,
        };
        if is_vertex {
            let p: Vec<f64> = numbers.iter().take(3).map(|n| n.parse().expect("a number")).collect();
            mesh.positions.push([p[0], p[1], p[2]].into());
            left = left.saturating_sub(1);
        } else {
            let base = u32::from(!is_off);
            let index =
                |n: &&str| n.split('/').next().and_then(|i| i.parse::<u32>().ok()).expect("an index") - base;
            let corners: Vec<u32> = numbers.iter().map(index).collect();
            mesh.triangles.extend((1..corners.len() - 1).map(|i| [corners[0], corners[i], corners[i + 1]]));
        }
    }
    mesh
}

fn check(path: &Path) {
    let mesh = read(path);
    let found = boundary(&mesh);
    let left_out: Vec<u32> = found.duplicates.iter().map(|f| f.0).collect();
    assert_eq!(boundary_net(&found), brute_net(&mesh, &left_out), "{}", path.display());
    let other = boundary(&renumbered(&shuffled_triangles(&mesh, 5), 6));
    assert_eq!(canonical(&other), canonical(&found), "{}", path.display());
    let all = loops(&found);
    assert_eq!(all.open_edges, 0);
    eprintln!(
        "{}: {} triangles, {} boundary edges, {} loops, {} components, {:?}",
        path.file_name().unwrap_or_default().display(),
        mesh.triangles.len(),
        found.edges.len(),
        all.loops.len(),
        components(&mesh, &found).list.len(),
        found.defects,
    );
}

#[test]
fn meshes_with_holes() {
    files("cgal-holes", "off").iter().for_each(|path| check(path));
}

#[test]
fn photogrammetry_tiles() {
    files("contextcapture-tiles/obj/L17", "obj").iter().for_each(|path| check(path));
}
