//! Makes tiled scenes with known holes.
fn main() {}
