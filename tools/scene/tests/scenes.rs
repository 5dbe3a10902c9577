//! What scenes promise: counts, the same bytes in any order, sound surfaces, exact borders.

mod support;

use scene::area::{SIDES, beyond};
use scene::class::{Class, Form};
use scene::encode::Format;
use scene::make::{MakeError, make};
use scene::maker::{CutOption, MakeOptions, Maker, OptionError};
use scene::preset::Preset;
use std::collections::BTreeSet;
use std::path::Path;
use support::{Place, check_surface, maker, tiles, triangles};

fn options(preset: Preset, triangles: u64, seed: u64) -> MakeOptions {
    MakeOptions { triangles: Some(triangles), seed, ..MakeOptions::new(preset) }
}

const A: Class = Class::Internal(Form::Hollow);
const B: Class = Class::Internal(Form::SemiEnclosed);
const C: Class = Class::Internal(Form::Crossing);
const D: Class = Class::Internal(Form::Island);
const EDGE_B: Class = Class::External(Form::SemiEnclosed);
const EDGE_D: Class = Class::External(Form::Island);

#[test]
fn presets_hold_their_counts_for_every_seed() {
    let small = vec![(Class::Closed, 2), (A, 1), (B, 5), (C, 1), (D, 1), (EDGE_B, 1)];
    let demo = vec![(Class::Closed, 4), (A, 2), (B, 10), (C, 3), (D, 1), (EDGE_B, 1)];
    let city = vec![(Class::Closed, 56), (A, 17), (B, 43), (C, 4), (D, 3), (EDGE_B, 5), (EDGE_D, 1)];
    let b = vec![(Class::Closed, 16), (A, 4), (B, 17), (D, 1), (EDGE_B, 2)];
    let b_added = vec![(Class::Closed, 20), (A, 5), (B, 20), (C, 4), (D, 4), (EDGE_B, 2)];
    let growing = vec![(Class::Closed, 4), (B, 7), (D, 1)];
    let presets = [
        (Preset::Small, 2_000, 9, small),
        (Preset::Demo, 4_000, 30, demo),
        (Preset::City, 2_000, 449, city),
        (Preset::A, 4_000, 4, vec![(B, 4), (EDGE_B, 1)]),
        (Preset::B, 4_000, 32, b),
        (Preset::BAdded, 4_000, 32, b_added),
        (Preset::Growing, 4_000, 8, growing),
    ];
    for (preset, triangles, cells, counts) in presets {
        for seed in 1..=5 {
            let folder = tempfile::tempdir().unwrap();
            let summary = make(&maker(options(preset, triangles, seed)), folder.path()).unwrap();
            assert_eq!(summary.cells, cells);
            assert_eq!(summary.counts.into_iter().collect::<Vec<_>>(), counts, "{preset:?}, seed {seed}");
        }
    }
}

#[test]
fn preset_a_has_the_asked_area_and_relief() {
    let scene = maker(options(Preset::A, 20_000, 1));
    let cells: Vec<_> = scene.plan().area.cells().map(|c| scene.cell(c).unwrap()).collect();
    let pieces = cells.iter().flat_map(|c| &c.pieces).filter(|p| p.hole == 0);
    let area_m2 = pieces.map(|p| p.doubled_area as f64 / 2.0 / 1024.0 / 1024.0).sum::<f64>();
    assert!((area_m2 / 57_000.0 - 1.0).abs() < 0.02, "{area_m2}");
    let heights = || cells.iter().flat_map(|c| &c.tile.vertices).map(|v| v[2]);
    let relief_m = (heights().max().unwrap() - heights().min().unwrap()) as f64 / 1024.0;
    assert!((1.2..2.8).contains(&relief_m), "{relief_m}");
}

#[test]
fn holes_that_the_triangles_cannot_show_are_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let failures = (1..=5).filter(|&seed| {
        let made = make(&maker(options(Preset::Demo, 128, seed)), &folder.path().join(seed.to_string()));
        matches!(made, Err(MakeError::Classes { .. } | MakeError::Pinched(_)))
    });
    assert!(failures.count() > 0, "coarse scenes fail for some seeds");
}

#[test]
fn contradictory_options_are_refused() {
    let shifted = MakeOptions { shift_m: [5e5, 0.0], ..MakeOptions::new(Preset::Small) };
    assert!(matches!(Maker::new(shifted), Err(OptionError::ShiftInSinglePrecision)));
    let wide = MakeOptions { cells: Some([200, 3]), ..MakeOptions::new(Preset::Small) };
    assert!(matches!(Maker::new(wide), Err(OptionError::TooWide { .. })));
    let few = MakeOptions { cells: Some([2, 3]), ..MakeOptions::new(Preset::Small) };
    assert!(matches!(Maker::new(few), Err(OptionError::Plan(_))));
    for m in [0.0, -1.0, f64::NAN, 50.0] {
        let cut = MakeOptions { cut: CutOption::Ragged(m), ..MakeOptions::new(Preset::Small) };
        assert!(matches!(Maker::new(cut), Err(OptionError::CutTooWide { .. })), "{m}");
    }
    assert!(matches!(Maker::new(options(Preset::Small, 10, 1)), Err(OptionError::Triangles { .. })));
}

#[test]
fn a_folder_with_files_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("mine"), "x").unwrap();
    let made = make(&maker(options(Preset::Small, 2_000, 1)), folder.path());
    assert!(matches!(made, Err(MakeError::NotEmpty(_))));
}

const CUTS: [CutOption; 4] =
    [CutOption::Exact, CutOption::Overrun(0.1), CutOption::Ragged(0.3), CutOption::Ragged(0.8)];

#[test]
fn cells_made_in_any_order_have_the_bytes_of_the_scene() {
    for cut in CUTS {
        let folder = tempfile::tempdir().unwrap();
        let mut options = options(Preset::Demo, 1_500, 3);
        options = MakeOptions { cut, shuffle: true, renumber: true, ..options };
        make(&maker(options.clone()), folder.path()).unwrap();
        let scene = maker(options);
        let mut cells: Vec<_> = scene.plan().area.cells().collect();
        cells.reverse();
        for cell in cells {
            let made = scene.cell(cell).unwrap();
            let name = scene.tile_name(cell);
            let path = folder.path().join(&name).join(format!("{name}.ply"));
            let file = std::fs::read(&path).ok();
            assert_eq!(file.is_none(), made.tile.triangles.is_empty());
            assert!(file.is_none_or(|bytes| bytes == scene.encode(&made)), "{cut:?} {name}");
        }
    }
}

#[test]
fn surfaces_are_sound_for_every_cut_and_seed() {
    for cut in CUTS {
        for seed in 1..=5 {
            let all = tiles(&maker(MakeOptions { cut, ..options(Preset::Demo, 1_800, seed) }));
            for tile in &all {
                check_surface(triangles(tile), &format!("{cut:?}, seed {seed}"));
                let used: BTreeSet<u32> = tile.triangles.iter().flatten().copied().collect();
                assert_eq!(used.len(), tile.vertices.len(), "every vertex is used");
            }
            if cut == CutOption::Exact {
                check_surface(all.iter().flat_map(triangles), &format!("whole scene, seed {seed}"));
            }
        }
    }
}

#[test]
fn the_city_is_sound_as_a_whole() {
    let all = tiles(&maker(options(Preset::City, 800, 2)));
    check_surface(all.iter().flat_map(triangles), "city");
}

#[test]
fn neighbours_share_border_vertices_bit_for_bit() {
    let scene = maker(options(Preset::Demo, 2_000, 4));
    let size = scene.frame().cell_size;
    let mut compared = 0;
    for cell in scene.plan().area.cells() {
        let here = scene.cell(cell).unwrap();
        for (axis, side) in [(0, SIDES[1]), (1, SIDES[2])] {
            let other = beyond(cell, side);
            if !scene.plan().area.contains(other) {
                continue;
            }
            let there = scene.cell(other).unwrap();
            let line = other[axis] * size;
            let on_line =
                |v: &[Place]| v.iter().filter(|p| p[axis] == line).copied().collect::<BTreeSet<_>>();
            let (ours, theirs) = (on_line(&here.tile.vertices), on_line(&there.tile.vertices));
            assert!(ours.is_subset(&theirs) || !there.pieces.is_empty());
            assert!(theirs.is_subset(&ours) || !here.pieces.is_empty());
            compared += ours.intersection(&theirs).count();
        }
    }
    assert!(compared > 800, "{compared}");
}

#[test]
fn overrunning_tiles_end_on_the_margin_and_share_nothing() {
    let scene = maker(MakeOptions { cut: CutOption::Overrun(0.1), ..options(Preset::Demo, 2_000, 4) });
    let (size, margin) = (scene.frame().cell_size, 102);
    assert_eq!(scene.overrun_m(), 102.0 / 1024.0);
    let whole: Vec<_> =
        scene.plan().area.cells().map(|c| scene.cell(c).unwrap()).filter(|c| c.pieces.is_empty()).collect();
    assert!(whole.len() > 5);
    let mut seen = BTreeSet::new();
    for cell in &whole {
        let [low, high] = [cell.cell.map(|k| k * size - margin), cell.cell.map(|k| (k + 1) * size + margin)];
        let on_line = |p: &&Place| (0..2).any(|k| p[k] == low[k] || p[k] == high[k]);
        assert_eq!(cell.tile.vertices.iter().filter(on_line).count(), 4 * 32);
        for p in &cell.tile.vertices {
            assert!((0..2).all(|k| low[k] <= p[k] && p[k] <= high[k]));
            seen.insert([p[0], p[1]]);
        }
    }
    let total: usize = whole.iter().map(|c| c.tile.vertices.len()).sum();
    assert!(seen.len() * 1000 > total * 999, "{} of {total}", seen.len());
}

#[test]
fn ragged_borders_stray_within_their_reach_on_both_sides() {
    let scene = maker(MakeOptions { cut: CutOption::Ragged(0.5), ..options(Preset::Demo, 2_000, 4) });
    let size = scene.frame().cell_size;
    let cell =
        scene.plan().area.cells().map(|c| scene.cell(c).unwrap()).find(|c| c.pieces.is_empty()).unwrap();
    let west = cell.cell[0] * size;
    let offsets: Vec<i64> = cell.tile.vertices.iter().map(|p| p[0] - west).filter(|d| *d < 1024).collect();
    assert!(offsets.iter().all(|d| (-512..=512).contains(d)), "{offsets:?}");
    assert!(offsets.iter().any(|d| *d > 100) && offsets.iter().any(|d| *d < -100));
    assert_eq!(offsets.len(), 33);
}

#[test]
fn used_and_lost_vertices_are_all_vertices() {
    let scene = maker(options(Preset::Small, 2_000, 2));
    let cells: Vec<_> = scene.plan().area.cells().map(|c| scene.cell(c).unwrap()).collect();
    let used: BTreeSet<Place> = cells.iter().flat_map(|c| &c.tile.vertices).copied().collect();
    let lost: Vec<Place> = cells.iter().flat_map(|c| &c.lost).map(|l| l.position).collect();
    let distinct: BTreeSet<Place> = lost.iter().copied().collect();
    assert_eq!(distinct.len(), lost.len(), "no vertex is listed twice");
    assert!(used.is_disjoint(&distinct));
    assert_eq!(used.len() + lost.len(), (3 * 32 + 1) * (3 * 32 + 1));
    let edge: Vec<_> = cells.iter().flat_map(|c| &c.lost).filter(|l| l.on_edge).collect();
    assert!(
        !edge.is_empty() && edge.iter().all(|l| l.position[0] == 0),
        "the hole at the edge lies in the west"
    );
}

fn triangle_set(scene: &Maker) -> BTreeSet<[Place; 3]> {
    let rotated = |mut t: [Place; 3]| {
        let least = (0..3).min_by_key(|&k| t[k]).unwrap_or(0);
        t.rotate_left(least);
        t
    };
    tiles(scene).iter().flat_map(|tile| triangles(tile).map(rotated).collect::<Vec<_>>()).collect()
}

#[test]
fn shuffled_and_renumbered_scenes_are_the_same_surface() {
    let plain = maker(options(Preset::Small, 2_000, 1));
    let mixed = maker(MakeOptions { shuffle: true, renumber: true, ..plain.options().clone() });
    let cell = plain.plan().area.cells().next().unwrap();
    assert_ne!(plain.encode(&plain.cell(cell).unwrap()), mixed.encode(&mixed.cell(cell).unwrap()));
    assert_eq!(triangle_set(&plain), triangle_set(&mixed));
}

#[test]
fn turned_and_mirrored_scenes_are_the_turned_surface() {
    let plain = maker(options(Preset::Small, 2_000, 1));
    let width = 3 * plain.frame().cell_size;
    let expected: [(u32, bool, fn([i64; 3], i64) -> Place); 3] = [
        (1, false, |[x, y, z], w| [w - y, x, z]),
        (2, false, |[x, y, z], w| [w - x, w - y, z]),
        (0, true, |[x, y, z], w| [w - x, y, z]),
    ];
    for (turns, mirror, map) in expected {
        let turned = maker(MakeOptions { turns, mirror, ..plain.options().clone() });
        let places = |s: &Maker| tiles(s).into_iter().flat_map(|t| t.vertices).collect::<BTreeSet<_>>();
        let mapped: BTreeSet<Place> = places(&plain).into_iter().map(|p| map(p, width)).collect();
        assert_eq!(mapped, places(&turned), "{turns} {mirror}");
        let all = tiles(&turned);
        check_surface(all.iter().flat_map(triangles), "turned");
        let folder = tempfile::tempdir().unwrap();
        let summary = make(&turned, folder.path()).unwrap();
        assert_eq!(summary.tiles, 8);
    }
}

#[test]
fn buildings_stand_away_from_holes_and_borders() {
    let plain = maker(options(Preset::Demo, 4_000, 1));
    let built = maker(MakeOptions { buildings: 6, ..plain.options().clone() });
    let mut raised = 0;
    for cell in plain.plan().area.cells() {
        let (a, b) = (plain.cell(cell).unwrap(), built.cell(cell).unwrap());
        assert_eq!(a.lost, b.lost, "the truth has no walls");
        raised += a.tile.vertices.iter().zip(&b.tile.vertices).filter(|(a, b)| a != b).count();
    }
    assert!(raised > 500, "{raised}");
}

#[test]
fn all_formats_hold_the_same_points() {
    let scene = maker(options(Preset::Small, 200, 1));
    let cell = scene.plan().area.cells().find(|c| scene.cell(*c).unwrap().pieces.is_empty());
    let made = scene.cell(cell.unwrap_or([0, 2])).unwrap();
    let points: Vec<[f64; 3]> = made.tile.vertices.iter().map(|v| v.map(|k| k as f64 / 1024.0)).collect();
    let bytes = |format| maker(MakeOptions { format, ..scene.options().clone() }).encode(&made);
    let single = bytes(Format::Ply);
    let body = |b: &[u8]| b.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
    let read_single = |b: &[u8]| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    let flat: Vec<f64> = points.iter().flatten().copied().collect();
    let rows = &single[body(&single)..];
    assert_eq!((0..flat.len()).map(|k| read_single(&rows[4 * k..])).collect::<Vec<_>>(), flat);
    let double = bytes(Format::PlyDouble);
    let rows = &double[body(&double)..];
    let read_double = |k: usize| f64::from_le_bytes(rows[8 * k..8 * k + 8].try_into().unwrap());
    assert_eq!((0..flat.len()).map(read_double).collect::<Vec<_>>(), flat);
    for (format, mark) in [(Format::Obj, "v "), (Format::PlyAscii, "")] {
        let text = String::from_utf8(bytes(format)).unwrap();
        let start = text.find("end_header\n").map_or(0, |k| k + 11);
        let lines =
            text[start..].lines().filter_map(|l| l.strip_prefix(mark)).filter(|l| !l.starts_with('#'));
        let numbers: Vec<f64> =
            lines.take(points.len()).flat_map(|l| l.split(' ').map(|n| n.parse().unwrap())).collect();
        assert_eq!(numbers, flat, "{format:?}");
    }
    check_glb(&bytes(Format::Glb), &points);
}

/// Reads a GLB of this tool back: z up = (x, -z, y) of node translation + position.
fn check_glb(bytes: &[u8], points: &[[f64; 3]]) {
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
    assert_eq!((&bytes[..4], word(4), word(8)), (&b"glTF"[..], 2, bytes.len()));
    let json_length = word(12);
    let json: serde_json::Value = serde_json::from_slice(&bytes[20..20 + json_length]).unwrap();
    let buffer = 20 + json_length + 8;
    assert_eq!((buffer % 4, word(buffer - 8)), (0, bytes.len() - buffer));
    let start = buffer + json["bufferViews"][1]["byteOffset"].as_u64().unwrap() as usize;
    let shift: Vec<f64> =
        json["nodes"][0]["translation"].as_array().unwrap().iter().map(|k| k.as_f64().unwrap()).collect();
    for (row, point) in points.iter().enumerate() {
        let at = |k: usize| f64::from(f32::from_bits(word(start + 12 * row + 4 * k) as u32)) + shift[k];
        assert_eq!([at(0), -at(2), at(1)], *point);
    }
}

#[test]
fn a_shift_moves_obj_coordinates_and_the_record() {
    let shift_m = [500_000.0, -4_000_000.0];
    let folder = tempfile::tempdir().unwrap();
    let plain = MakeOptions { format: Format::Obj, ..options(Preset::Small, 2_000, 1) };
    make(&maker(MakeOptions { shift_m, ..plain.clone() }), &folder.path().join("shifted")).unwrap();
    make(&maker(plain), &folder.path().join("plain")).unwrap();
    let first = |name: &str| -> Vec<f64> {
        let path = folder.path().join(name).join("truth.csv");
        let text = std::fs::read_to_string(path).unwrap();
        text.lines().nth(1).unwrap().split(',').map(|n| n.parse().unwrap()).collect()
    };
    let (shifted, plain) = (first("shifted"), first("plain"));
    assert_eq!([shifted[0] - plain[0], shifted[1] - plain[1]], shift_m);
    assert_eq!(shifted[2], plain[2]);
}

#[test]
fn the_record_lists_what_is_in_the_folder() {
    let folder = tempfile::tempdir().unwrap();
    let summary = make(&maker(options(Preset::Demo, 2_000, 1)), folder.path()).unwrap();
    let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
    let json: serde_json::Value = serde_json::from_str(&read("scene.json")).unwrap();
    assert_eq!(json["kinds"]["I-B"], 10);
    assert_eq!((&json["cell"], &json["nx"], &json["ny"]), (&100.0.into(), &6.into(), &5.into()));
    let truth: u64 =
        json["holes"].as_array().unwrap().iter().map(|h| h["truth_vertices"].as_u64().unwrap()).sum();
    assert_eq!(truth as usize, read("truth.csv").lines().count() - 1);
    assert_eq!(json["holes"][0]["cells"]["2,2"], "I-A");
    let bytes: u64 = json["cells"]
        .as_array()
        .unwrap()
        .iter()
        .filter_map(|c| c["tile"].as_str())
        .map(|t| std::fs::metadata(folder.path().join(t).join(format!("{t}.ply"))).unwrap().len())
        .sum();
    assert_eq!(bytes, summary.bytes);
}

#[test]
fn the_small_scene_in_the_test_data_is_made_again_byte_for_byte() {
    let stored = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../testdata/scenes/small");
    let folder = tempfile::tempdir().unwrap();
    let made = folder.path().join("small");
    make(&maker(MakeOptions::new(Preset::Small)), &made).unwrap();
    let names = files_below(&made);
    let stored_names: Vec<_> = files_below(&stored).into_iter().filter(|n| n != "README.md").collect();
    assert_eq!(names, stored_names);
    for name in names {
        let same = std::fs::read(made.join(&name)).unwrap() == std::fs::read(stored.join(&name)).unwrap();
        assert!(same, "{name} differs: see testdata/scenes/small/README.md");
    }
}

fn files_below(folder: &Path) -> Vec<String> {
    let mut names = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap().map(Result::unwrap) {
        let name = entry.file_name().into_string().unwrap();
        if entry.path().is_dir() {
            names.extend(files_below(&entry.path()).into_iter().map(|below| format!("{name}/{below}")));
        } else {
            names.push(name);
        }
    }
    names.sort();
    names
}

#[test]
fn tiles_alone_are_those_of_the_scene() {
    let folder = tempfile::tempdir().unwrap();
    let (whole, alone) = (folder.path().join("whole"), folder.path().join("alone"));
    let scene = maker(options(Preset::Small, 2_000, 2));
    let summary = make(&scene, &whole).unwrap();
    assert_eq!(scene::make::make_tiles(&scene, &alone).unwrap(), summary);
    let mut tiles = 0;
    for entry in std::fs::read_dir(&alone).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        let file = Path::new(&name).join(&name).with_extension("ply");
        assert!(
            std::fs::read(alone.join(&file)).unwrap() == std::fs::read(whole.join(&file)).unwrap(),
            "{name}"
        );
        tiles += 1;
    }
    assert_eq!(tiles, summary.tiles);
}
