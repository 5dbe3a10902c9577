//! How fast a tile of 200,000 triangles is read in each format, from the page cache; and, where there is one, a tile of a
//! real delivery with the boundary of its mesh.
#![allow(clippy::print_stderr, reason = "it says what it leaves out")]

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use lacuna_mesh::boundary;
use lacuna_tile::{ReadOptions, TileFormat, read_tile};
use scene::encode::Format;
use scene::maker::{MakeOptions, Maker};
use scene::preset::Preset;
use std::path::{Path, PathBuf};

/// Beside the repository: `(cd .. && ls shared/data)`.
const REAL: &str = "../../../shared/data/contextcapture-tiles/obj/L18";

fn made(criterion: &mut Criterion) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut group = criterion.benchmark_group("read");
    group.sample_size(20);
    for (name, format, reader) in [
        ("PLY", Format::Ply, TileFormat::Ply),
        ("PLY in f64", Format::PlyDouble, TileFormat::Ply),
        ("PLY in ASCII", Format::PlyAscii, TileFormat::Ply),
        ("OBJ", Format::Obj, TileFormat::Obj),
        ("GLB", Format::Glb, TileFormat::Glb),
    ] {
        let options = MakeOptions { triangles: Some(200_000), format, ..MakeOptions::new(Preset::Growing) };
        let maker = Maker::new(options).expect("options");
        let bytes = maker.encode(&maker.cell([0, 0]).expect("a cell"));
        let path = folder.path().join(name).with_extension(format.extension());
        std::fs::write(&path, &bytes).expect("a file");
        group.throughput(Throughput::Bytes(bytes.len() as u64));
        group.bench_function(name, |b| {
            b.iter(|| read_tile(&path, reader, &ReadOptions::default()).expect("a tile"));
        });
    }
}

fn real(criterion: &mut Criterion) {
    let Some(path) = largest_obj(&Path::new(env!("CARGO_MANIFEST_DIR")).join(REAL)) else {
        eprintln!("no {REAL}: the real tile is left out");
        return;
    };
    let read = || read_tile(&path, TileFormat::Obj, &ReadOptions::default()).expect("a tile");
    let mesh = read().mesh;
    let mut group = criterion.benchmark_group("real tile");
    group.throughput(Throughput::Bytes(std::fs::metadata(&path).expect("a file").len()));
    group.bench_function("OBJ", |b| b.iter(read));
    group.throughput(Throughput::Elements(mesh.triangles.len() as u64));
    group.bench_function("boundary", |b| b.iter(|| boundary(&mesh)));
}

fn largest_obj(folder: &Path) -> Option<PathBuf> {
    let mut files = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for entry in std::fs::read_dir(next).ok()?.flatten() {
            let path = entry.path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "obj") {
                files.push((entry.metadata().map_or(0, |m| m.len()), path));
            }
        }
    }
    files.into_iter().max().map(|(_, path)| path)
}

criterion_group!(benches, made, real);
criterion_main!(benches);
