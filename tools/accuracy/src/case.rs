//! Which scenes are measured.

use scene::preset::Preset;

/// One scene to measure.
#[derive(Clone, Debug)]
pub struct Case {
    /// Short name, unique; also its folder.
    pub name: String,
    /// What the tables call its kind: seeds of one kind stand in one row.
    pub kind: &'static str,
    /// Where it comes from.
    pub source: Source,
}

/// Where a scene comes from.
#[derive(Clone, Debug)]
pub enum Source {
    /// Made by the tool `scene`, then given other heights.
    Made {
        /// Which holes and cells.
        preset: Preset,
        /// Triangles a cell.
        triangles: u64,
        /// Seed of places, terrain and disturbances.
        seed: u64,
        /// Heights.
        ground: Ground,
        /// What happens to the rims.
        rim: RimFault,
    },
    /// Discs dug into a folder of tiles, named relative to the data folder.
    Dug {
        /// The folder.
        folder: &'static str,
        /// How many discs.
        discs: usize,
        /// Least and largest radius, metres.
        radius_m: [f64; 2],
        /// Centres on borders between tiles.
        across_borders: bool,
        /// Seed of their places.
        seed: u64,
    },
}

/// Heights of a made scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ground {
    /// Waves down to 0.4 cells: smooth at the size of the holes' rims.
    Smooth,
    /// The same with short waves over them: rough down to the triangles.
    Rough,
    /// The matplotlib sample terrain, one metre a pixel, a hundredth of its height.
    Elevation,
}

/// What is wrong with the two rings of vertices round every hole. The truth stays as it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RimFault {
    /// Nothing.
    None,
    /// Normal noise of this standard deviation, metres.
    Noise(f64),
    /// The rim bent up by this much, half of it one ring behind, metres.
    Curl(f64),
    /// This share of the vertices is 0.4 to 1.2 m off.
    Outliers(f64),
}

/// Scenes of the short run: seconds, and no data but what the tool makes.
#[must_use]
pub fn quick() -> Vec<Case> {
    let a = |kind, ground, rim| made(kind, Preset::A, 3_000, 1, ground, rim);
    vec![
        a("smooth", Ground::Smooth, RimFault::None),
        a("outliers 5 %", Ground::Smooth, RimFault::Outliers(0.05)),
        made("hollow", Preset::Small, 1_000, 1, Ground::Smooth, RimFault::None),
    ]
}

/// All scenes. `with_data`: those on real data, too.
#[must_use]
pub fn full(with_data: bool) -> Vec<Case> {
    let kinds = [
        ("smooth", Ground::Smooth, RimFault::None),
        ("rough", Ground::Rough, RimFault::None),
        ("noise 5 cm", Ground::Smooth, RimFault::Noise(0.05)),
        ("curl 10 cm", Ground::Smooth, RimFault::Curl(0.1)),
        ("outliers 5 %", Ground::Smooth, RimFault::Outliers(0.05)),
        ("outliers 15 %", Ground::Smooth, RimFault::Outliers(0.15)),
    ];
    let mut cases = Vec::new();
    for (kind, ground, rim) in kinds {
        cases.extend((1..=3).map(|seed| made(kind, Preset::A, 20_000, seed, ground, rim)));
    }
    let hollow = |seed| made("hollow", Preset::Small, 8_000, seed, Ground::Smooth, RimFault::None);
    cases.extend((1..=3).map(hollow));
    if with_data {
        cases.push(made("elevation", Preset::A, 20_000, 1, Ground::Elevation, RimFault::None));
        cases.extend((1..=2).map(|seed| dug("laser", "ahn3-delft/tiles_dsm_50m", 6, [4.0, 10.0], seed)));
        cases.extend((1..=2).map(|seed| dug("photo", "contextcapture-tiles/obj/L17", 4, [6.0, 14.0], seed)));
    }
    cases
}

fn made(
    kind: &'static str,
    preset: Preset,
    triangles: u64,
    seed: u64,
    ground: Ground,
    rim: RimFault,
) -> Case {
    let source = Source::Made { preset, triangles, seed, ground, rim };
    Case { name: name(kind, seed), kind, source }
}

fn dug(kind: &'static str, folder: &'static str, discs: usize, radius_m: [f64; 2], seed: u64) -> Case {
    let source = Source::Dug { folder, discs, radius_m, across_borders: true, seed };
    Case { name: name(kind, seed), kind, source }
}

/// Letters and digits only: it names folders and pictures.
fn name(kind: &str, seed: u64) -> String {
    let word: String = kind.chars().filter(char::is_ascii_alphanumeric).collect();
    format!("{word}_{seed}")
}
