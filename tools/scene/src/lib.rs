//! Makes tiled scenes with known holes of every class, and digs holes into real ones.
//!
//! `scene make` plans holes ([`preset`], [`stamp`]), makes each cell's triangulated lattice ([`lattice`]), leaves out the
//! triangles that holes take and cleans the rims ([`removal`]), counts the classes on what is left ([`classify`]), and
//! writes tiles, `scene.json` and `truth.csv` ([`mod@make`]). One cell is in memory at a time, and any cell can be made
//! alone with the same bytes. `scene dig` ([`mod@dig`]) takes faces out of existing tiles.

pub mod area;
pub mod class;
pub mod classify;
pub mod dig;
pub mod encode;
pub mod frame;
pub mod hole;
pub mod lattice;
pub mod make;
pub mod maker;
pub mod order;
pub mod plan;
pub mod preset;
pub mod random;
mod record;
pub mod removal;
pub mod shape;
pub mod stamp;
pub mod terrain;
pub mod tile;
