//! Plain values that go in and out of this crate.

use glam::{DAffine3, DVec3};
use lacuna_mesh::{TriMesh, VertexId};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// File format of a tile.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum TileFormat {
    /// Stanford PLY: ascii, binary little endian, binary big endian.
    Ply,
    /// Wavefront OBJ.
    Obj,
    /// Binary glTF 2.0.
    Glb,
}

impl TileFormat {
    /// The format that a path's extension names, in any case of letters; `None` for every other extension.
    #[must_use]
    pub fn from_path(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?;
        [("ply", Self::Ply), ("obj", Self::Obj), ("glb", Self::Glb)]
            .into_iter()
            .find_map(|(name, format)| extension.eq_ignore_ascii_case(name).then_some(format))
    }
}

/// Which axis of the file points up. The scene is z up always.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum UpAxis {
    /// y up: scene = (x, -z, y).
    Y,
    /// z up: scene = file.
    Z,
}

impl UpAxis {
    /// The map from file positions to scene positions.
    #[must_use]
    pub fn to_scene(self) -> DAffine3 {
        match self {
            Self::Y => DAffine3::from_cols(DVec3::X, DVec3::Z, DVec3::NEG_Y, DVec3::ZERO),
            Self::Z => DAffine3::IDENTITY,
        }
    }
}

/// How a file stores a coordinate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum NumberType {
    /// 32-bit float.
    F32,
    /// 64-bit float.
    F64,
    /// Decimal text without a declared type (OBJ): any f64 comes back bit for bit.
    Decimal,
}

/// How positions of one tile relate to the scene, and what writing does to them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct VertexFrame {
    /// Number type of a stored coordinate.
    pub number: NumberType,
    /// Stored position to scene position (metres, z up).
    pub to_scene: DAffine3,
}

impl VertexFrame {
    /// The scene position that comes back after writing `scene` (metres) to this tile and reading it again.
    #[must_use]
    pub fn round(&self, scene: DVec3) -> DVec3 {
        let stored = self.to_file(scene);
        if self.to_scene == DAffine3::IDENTITY { stored } else { self.to_scene.transform_point3(stored) }
    }

    /// The coordinates that the file stores for a scene position (metres), rounded to its number type.
    #[must_use]
    pub fn to_file(&self, scene: DVec3) -> DVec3 {
        let identity = self.to_scene == DAffine3::IDENTITY;
        let local = if identity { scene } else { self.to_scene.inverse().transform_point3(scene) };
        match self.number {
            NumberType::F32 => local.as_vec3().as_dvec3(),
            NumberType::F64 | NumberType::Decimal => local,
        }
    }
}

/// How a tile is read. The default follows the format and sets no limit.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ReadOptions {
    /// Up axis that overrides the format's own (PLY and OBJ: z; GLB: y).
    pub up_axis: Option<UpAxis>,
    /// Files above this size are refused before anything is allocated.
    pub max_bytes: Option<u64>,
    /// Leave out the hash of the file (`inspect` does not hash): `ReadTile::hash` is then all zeros.
    pub skip_hash: bool,
}

/// A tile in memory.
#[derive(Clone, Debug, PartialEq)]
pub struct ReadTile {
    /// Positions in the file's order, triangles in the file's order (polygons cut into triangles where they stand).
    /// Triangles that touch a non-finite position are left out and counted in a warning.
    pub mesh: TriMesh,
    /// Stored coordinates against scene coordinates.
    pub frame: VertexFrame,
    /// blake3 of the file, taken from the very buffer that was parsed.
    pub hash: [u8; 32],
    /// Size of the file.
    pub bytes: u64,
    /// True if the vertices have colours.
    pub has_colour: bool,
    /// Names of side files that the tile mentions, as written (OBJ: `mtllib`; PLY: `TextureFile` comments; GLB: image
    /// URIs). Never opened here.
    pub textures: Vec<String>,
    /// Leniencies, one line each.
    pub warnings: Vec<String>,
}

/// Size of a tile, from its header alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TileHeader {
    /// Number of vertices; OBJ: estimated from the file's size.
    pub vertices: u64,
    /// Number of triangles; PLY: of faces; OBJ: estimated from the file's size.
    pub triangles: u64,
    /// Size of the file.
    pub bytes: u64,
}

/// A corner of a patch triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum Corner {
    /// A vertex of the tile.
    Original(VertexId),
    /// `HolePatch::vertices[i]`.
    New(u32),
}

/// The patch of one hole in one tile, with what the marks say about it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HolePatch {
    /// Id of the hole.
    pub hole: String,
    /// Id of its cluster.
    pub cluster: String,
    /// "closed", "I" or "II".
    pub class: String,
    /// "A", "B", "C", "D"; `None` for closed holes.
    pub shape: Option<String>,
    /// Where the surface comes from: "field", "layered", "aggregate".
    pub method: String,
    /// How the contour became triangles.
    pub filler: String,
    /// Area of the hole, square metres.
    pub area_m2: f64,
    /// New vertices, scene frame, metres, already rounded by `VertexFrame::round`.
    pub vertices: Vec<DVec3>,
    /// Triangles, counter-clockwise seen from above.
    pub triangles: Vec<[Corner; 3]>,
}

/// What `append_patches` writes.
#[derive(Clone, Copy, Debug)]
pub struct AppendRequest<'a> {
    /// The tile as delivered; only read.
    pub input: &'a Path,
    /// The repaired tile; appears whole or not at all.
    pub output: &'a Path,
    /// Format of both.
    pub format: TileFormat,
    /// The options the tile was scanned with.
    pub options: &'a ReadOptions,
    /// Hash of the tile when it was scanned; another one now is an error.
    pub expected_hash: Option<[u8; 32]>,
    /// Patches in writing order. None at all: the output is the same bytes.
    pub patches: &'a [HolePatch],
}

/// What `new_tile` writes: a tile for a cell that has none.
#[derive(Clone, Copy, Debug)]
pub struct NewTileRequest<'a> {
    /// A tile whose header, properties and number type the new one takes over; only read.
    pub template: &'a Path,
    /// The new tile; appears whole or not at all.
    pub output: &'a Path,
    /// Format of both.
    pub format: TileFormat,
    /// The options the template was scanned with.
    pub options: &'a ReadOptions,
    /// Patches in writing order; all corners are `Corner::New`.
    pub patches: &'a [HolePatch],
}

/// A tile that was written and is durable.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Written {
    /// Size of the tile.
    pub bytes: u64,
    /// blake3 of the tile.
    pub hash: [u8; 32],
    /// Names of files written beside the tile (OBJ: its patch material).
    pub side_files: Vec<String>,
}
