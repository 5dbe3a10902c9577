//! lacuna-tile
